#pragma once

// Checked access to the fields of a JSON file. A fault names the place in the file. Only the .cpp
// files of this folder include this header.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/read_dataset.h"

namespace pickbed::eval {

using ParsedJson = nlohmann::json;

// Place in a file for messages, for example "scene_gt.json: image 3: instance 0".
class JsonPlace {
 public:
  JsonPlace(std::string text, const OnFault& fault) : text_(std::move(text)), fault_(fault) {}
  JsonPlace operator/(const std::string& key) const { return {text_ + ": " + key, fault_}; }
  void Fault(const std::string& what) const { fault_(text_ + ": " + what); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  const OnFault& fault_;
};

// Parses a JSON file. Reports a fault and returns nullopt if the file is missing or not JSON. NaN
// is not JSON.
std::optional<ParsedJson> ReadJson(const std::filesystem::path& file, const OnFault& fault);

// Largest size of a number in a data set. Larger ones have no meaning in mm, px or degrees, and
// products of them would not be finite.
inline constexpr double kLargestNumber = 1e9;

// Return the value of a key. They report a fault and return nullopt if it is absent, has the wrong
// type, or is beyond kLargestNumber. Reals expects `count` numbers.
std::optional<double> JsonReal(const ParsedJson& object, const char* key, const JsonPlace& place);
// Same for a whole number.
std::optional<int> JsonInteger(const ParsedJson& object, const char* key, const JsonPlace& place);
// Same for an array of `count` finite numbers.
std::optional<std::vector<double>> JsonReals(const ParsedJson& object, const char* key,
                                             size_t count, const JsonPlace& place);
// Converts an array, flat or nested, to `count` finite numbers. Reports a fault and returns nullopt
// for anything else.
std::optional<std::vector<double>> ToReals(const ParsedJson& array, size_t count,
                                           const JsonPlace& place);

// Converts nine numbers, row by row.
Eigen::Matrix3d ToMatrix3(const std::vector<double>& numbers);

}  // namespace pickbed::eval
