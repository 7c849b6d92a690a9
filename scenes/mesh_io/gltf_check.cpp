#include "scenes/mesh_io/gltf_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings_tree.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/text_words.h"

namespace pickbed::scenes {
namespace {

using Json = nlohmann::json;

// All keys of glTF 2.0 (Khronos, glTF 2.0 specification, section 5).
const std::vector<std::string_view>& GltfKeys() {
  constexpr std::string_view kNames =
      "accessors alphaCutoff alphaMode animations aspectRatio asset attributes "
      "baseColorFactor baseColorTexture buffer buffers bufferView bufferViews byteLength "
      "byteOffset byteStride camera cameras channels children componentType copyright "
      "count doubleSided emissiveFactor emissiveTexture extensions extensionsRequired "
      "extensionsUsed extras generator images index indices input interpolation "
      "inverseBindMatrices joints magFilter material materials matrix max mesh meshes "
      "metallicFactor metallicRoughnessTexture mimeType min minFilter minVersion mode name "
      "node nodes normalized normalTexture occlusionTexture orthographic output path "
      "pbrMetallicRoughness perspective primitives rotation roughnessFactor sampler "
      "samplers scale scene scenes skeleton skin skins source sparse strength target "
      "targets texCoord textures translation type uri values version weights wrapS wrapT "
      "xmag ymag yfov zfar znear";
  static const std::vector<std::string_view> kKeys = WordsIn(kNames);
  return kKeys;
}

// Keys whose values are whole numbers.
const std::set<std::string_view>& KeysOfWholeNumbers() {
  static const std::set<std::string_view> kKeys = {
      "buffer",        "bufferView", "byteLength",
      "byteOffset",    "byteStride", "camera",
      "componentType", "count",      "index",
      "indices",       "magFilter",  "material",
      "mesh",          "minFilter",  "mode",
      "node",          "sampler",    "scene",
      "skin",          "source",     "texCoord",
      "wrapS",         "wrapT",      "skeleton",
      "input",         "output",     "inverseBindMatrices"};
  return kKeys;
}

// Keys whose values are lists of numbers, and how many these are.
const std::map<std::string_view, size_t>& KeysOfNumberLists() {
  static const std::map<std::string_view, size_t> kKeys = {
      {"matrix", 16},  {"translation", 3},     {"scale", 3},
      {"rotation", 4}, {"baseColorFactor", 4}, {"emissiveFactor", 3}};
  return kKeys;
}

std::string ShownJson(const Json& value) {
  constexpr size_t kLongest = 60;
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return OneLine(text.size() > kLongest ? text.substr(0, kLongest) + "..." : text);
}

class GltfChecker {
 public:
  explicit GltfChecker(const std::filesystem::path& path) : path_(path) {}

  Json Parsed(const std::string& text) const {
    std::vector<std::set<std::string>> keys;  // of the open objects
    const auto check = [&](int depth, Json::parse_event_t event, const Json& parsed) {
      if (depth > kMaxDepth) Refuse("its text", "is nested too deep");
      if (event == Json::parse_event_t::object_start) keys.emplace_back();
      if (event == Json::parse_event_t::object_end) keys.pop_back();
      if (event != Json::parse_event_t::key) return true;
      const std::string key = parsed.get<std::string>();
      if (!keys.back().insert(key).second) {
        Refuse("an object", fmt::format("has the key '{}' twice", OneLine(key)));
      }
      return true;
    };
    try {
      return Json::parse(text, check);
    } catch (const Json::parse_error& error) {
      Refuse("its text", fmt::format("is no JSON from byte {} on", error.byte));
    } catch (const Json::exception&) {  // a number beyond all numbers
      Refuse("its text", "has a number that is too large");
    }
  }

  void Check(const Json& file) const {
    if (!file.is_object()) Refuse("its text", "is no object of glTF");
    const auto asset = file.find("asset");
    const Json version =
        asset == file.end() || !asset->is_object() ? Json() : asset->value("version", Json());
    const auto number = version.is_string() ? version.get<std::string>() : version.dump();
    if (number == "1" || number.starts_with("1.")) return;
    if (number != "2" && !number.starts_with("2.")) {
      Refuse("asset", fmt::format("has '{}' for version, which is none", OneLine(number)));
    }
    CheckObject(file, "");
  }

 private:
  static constexpr int kMaxDepth = 64;

  [[noreturn]] void Refuse(const std::string& place, const std::string& what) const {
    RefuseUnreadable(path_, place + " " + what);
  }

  // `place`: of the object in the file, such as "nodes/2"; empty = the whole file.
  void CheckObject(const Json& object, const std::string& place) const {
    for (const auto& [key, value] : object.items()) {
      // Extensions and extras have keys of their own.
      if (key == "extensions" || key == "extras") continue;
      const std::string here = place.empty() ? key : place + "/" + key;
      if (!IsKnown(key, here)) continue;
      CheckValue(key, value, here);
      if (key != "attributes") CheckChildren(value, here);
    }
  }

  void CheckChildren(const Json& value, const std::string& place) const {
    if (value.is_object()) CheckObject(value, place);
    if (!value.is_array()) return;
    for (size_t i = 0; i < value.size(); ++i) {
      if (value[i].is_structured()) CheckChildren(value[i], fmt::format("{}/{}", place, i));
    }
  }

  // Returns whether glTF has this key. Programs may add others, but not one with a wrong letter.
  bool IsKnown(const std::string& key, const std::string& place) const {
    const std::vector<std::string_view>& keys = GltfKeys();
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) return true;
    constexpr size_t kShort = 5;  // a shorter key is too near to other words
    const auto near = std::find_if(keys.begin(), keys.end(), [&](std::string_view known) {
      return key.size() >= kShort && IsDamagedKey(key, known);
    });
    if (near == keys.end()) return false;
    Refuse("'" + OneLine(place) + "'", fmt::format("is an unknown key; did you mean {}?", *near));
  }

  void CheckValue(const std::string& key, const Json& value, const std::string& place) const {
    if (key == "attributes") CheckAttributes(value, place);
    // The indices of a sparse accessor are an object.
    const bool is_sparse = key == "indices" && value.is_object();
    if (KeysOfWholeNumbers().contains(key) && !is_sparse) CheckWholeNumber(value, place);
    if (key == "children" || key == "joints" || key == "nodes") CheckIndices(value, place);
    constexpr uint64_t kLastMode = 6;  // a fan of triangles
    if (key == "mode" && value.get<uint64_t>() > kLastMode) {
      Refuse(place, "is " + ShownJson(value) + ", which is no mode");
    }
    const auto list = KeysOfNumberLists().find(key);
    // The scale of a texture of normals is one number.
    if (list == KeysOfNumberLists().end() || (key == "scale" && value.is_number())) return;
    CheckNumbers(value, list->second, place);
    if (key == "baseColorFactor") CheckColor(value, place);
    if (key == "rotation") CheckRotation(value, place);
    if (key == "matrix") CheckLastRow(value, place);
  }

  // The matrix of a node is stored column by column. Its last row must be 0 0 0 1, which the reader
  // would assume for any other one.
  void CheckLastRow(const Json& matrix, const std::string& place) const {
    constexpr double kMaxError = 1e-3;
    for (size_t column = 0; column < 4; ++column) {
      const double value = matrix[4 * column + 3].get<double>();
      if (std::abs(value - (column == 3 ? 1 : 0)) < kMaxError) continue;
      Refuse(place, fmt::format("has the last row {} {} {} {}, not 0 0 0 1",
                                matrix[3].get<double>(), matrix[7].get<double>(),
                                matrix[11].get<double>(), matrix[15].get<double>()));
    }
  }

  // The nodes of the file are objects, the ones of a scene are indices.
  void CheckIndices(const Json& list, const std::string& place) const {
    if (!list.is_array()) Refuse(place, "is " + ShownJson(list) + ", which is no list");
    for (const Json& item : list) {
      if (!item.is_object()) CheckWholeNumber(item, place);
    }
  }

  void CheckWholeNumber(const Json& value, const std::string& place) const {
    if (value.is_number_unsigned() && value.get<uint64_t>() < (uint64_t{1} << 32)) return;
    Refuse(place, "is " + ShownJson(value) + ", which is no whole number from 0 on");
  }

  void CheckNumbers(const Json& value, size_t count, const std::string& place) const {
    const auto is_number = [](const Json& item) { return item.is_number(); };
    if (value.is_array() && value.size() == count &&
        std::all_of(value.begin(), value.end(), is_number)) {
      return;
    }
    Refuse(place, fmt::format("is {}, not {} numbers", ShownJson(value), count));
  }

  // Colors are rounded by the programs that write them.
  void CheckColor(const Json& color, const std::string& place) const {
    constexpr double kRounded = 1e-3;
    for (const Json& channel : color) {
      const auto number = channel.get<double>();
      if (number >= 0 && number <= 1 + kRounded) continue;
      Refuse(place, "has " + ShownJson(channel) + ", which is not within 0 and 1");
    }
  }

  void CheckRotation(const Json& quaternion, const std::string& place) const {
    constexpr double kTolerance = 0.01;
    double square = 0;
    for (const Json& number : quaternion) square += std::pow(number.get<double>(), 2);
    if (std::abs(std::sqrt(square) - 1) <= kTolerance) return;
    Refuse(place, "is " + ShownJson(quaternion) + ", whose length is not 1");
  }

  // Programs and extensions may add other names, but not one with a wrong letter.
  void CheckAttributes(const Json& attributes, const std::string& place) const {
    constexpr auto kNames = std::to_array<std::string_view>(
        {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"});
    for (const auto& [key, value] : attributes.items()) {
      CheckWholeNumber(value, place + "/" + OneLine(key));
      const auto is_begin = [&key](std::string_view name) {
        if (!name.ends_with('_')) return key == name;
        return key.starts_with(name) && key.size() > name.size() &&
               key.find_first_not_of("0123456789", name.size()) == std::string::npos;
      };
      const auto is_damaged = [&key](std::string_view name) {
        return IsDamagedKey(key, std::string(name) + (name.ends_with('_') ? "0" : ""));
      };
      if (std::any_of(kNames.begin(), kNames.end(), is_begin)) continue;
      if (std::none_of(kNames.begin(), kNames.end(), is_damaged)) continue;
      Refuse(place, fmt::format("has the unknown name '{}'", OneLine(key)));
    }
  }

  const std::filesystem::path& path_;
};

// Returns the text of a glTF file, or the first chunk of a GLB file; nullopt for version 1 of GLB.
std::optional<std::string> TextOfGltf(const std::filesystem::path& path) {
  const std::string bytes = ReadFileBytes(path);
  if (LowerExtension(path) != ".glb") return bytes;
  std::array<uint32_t, 5> head{};  // magic, version, length, length and type of the first chunk
  if (bytes.size() < sizeof head) RefuseUnreadable(path, "its header is cut short");
  std::memcpy(head.data(), bytes.data(), sizeof head);
  if (head[1] == 1) return std::nullopt;
  if (head[2] != bytes.size()) {
    RefuseUnreadable(
        path, fmt::format("its header names {} bytes, but it has {}", head[2], bytes.size()));
  }
  if (head[3] > bytes.size() - sizeof head) {
    RefuseUnreadable(path, fmt::format("its text has {} bytes, which it has no room for", head[3]));
  }
  // Some programs fill it up with zeros in place of spaces.
  const std::string text = bytes.substr(sizeof head, head[3]);
  return text.substr(0, text.find_last_not_of('\0') + 1);
}

}  // namespace

void CheckGltf(const std::filesystem::path& path) {
  const std::optional<std::string> text = TextOfGltf(path);
  if (!text) return;
  const GltfChecker checker(path);
  checker.Check(checker.Parsed(*text));
}

}  // namespace pickbed::scenes
