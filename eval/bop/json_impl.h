#pragma once

// Fields of a JSON file with faults that say where. For the .cpp files of this folder alone.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/dataset.h"

namespace pickbed::bop {

using Json = nlohmann::json;

// A place in a file, for messages: "scene_gt.json: image 3: instance 0".
class Place {
 public:
  Place(std::string text, const OnFault& fault) : text_(std::move(text)), fault_(fault) {}
  Place operator/(const std::string& part) const { return {text_ + ": " + part, fault_}; }
  void Fault(const std::string& what) const { fault_(text_ + ": " + what); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  const OnFault& fault_;
};

// Nothing, and a fault, when the file is missing or no JSON (NaN is none).
std::optional<Json> ReadJson(const std::filesystem::path& file, const OnFault& fault);

// The value of a key. Nothing, and a fault, when it is absent or not what it should be.
std::optional<double> Real(const Json& object, const char* key, const Place& place);
std::optional<int> Integer(const Json& object, const char* key, const Place& place);
std::optional<std::vector<double>> Reals(const Json& object, const char* key, size_t count,
                                         const Place& place);
// `count` finite numbers; nothing, and a fault, for anything else.
std::optional<std::vector<double>> ToReals(const Json& array, size_t count, const Place& place);

// Three rows of three.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& numbers);

}  // namespace pickbed::bop
