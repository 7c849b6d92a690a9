#include "scenes/mesh_io/material_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/number_words.h"
#include "scenes/mesh_io/text_words.h"

namespace pickbed::scenes {
namespace {

using Words = std::vector<std::string_view>;

// Values of a statement of numbers.
struct Numbers {
  size_t fewest, limit;  // how many there are
  double min, max;
};

constexpr double kAny = 1e9;
// Colors are rounded by the programs that write them. A single number means a grey, but the
// importer reads a red. It is also what is left of a line that is cut.
constexpr Numbers kColor{3, 3, 0, 1 + 1e-3}, kLight{1, 3, 0, kAny}, kOne{1, 1, 0, kAny};

// Statements with numbers. Those with P are from the extension for physically based rendering.
const std::map<std::string_view, Numbers>& NumberStatements() {
  static const std::map<std::string_view, Numbers> kStatements = {
      {"Ka", kColor},      {"Kd", kColor},  {"Ks", kColor},  {"Ke", kLight}, {"Tf", kLight},
      {"Tr", kOne},        {"d", kOne},     {"Ns", kOne},    {"Ni", kOne},   {"illum", kOne},
      {"sharpness", kOne}, {"Pr", kOne},    {"Pm", kOne},    {"Ps", kOne},   {"Pc", kOne},
      {"Pcr", kOne},       {"aniso", kOne}, {"anisor", kOne}};
  return kStatements;
}

// Statements with other words.
const std::vector<std::string>& OtherStatements() {
  static const std::vector<std::string> kStatements = {
      "newmtl", "map_Ka", "map_Kd", "map_Ks", "map_Ke",  "map_Ns",   "map_Ni",   "map_d",
      "map_Tr", "map_Pr", "map_Pm", "map_Ps", "map_aat", "map_Bump", "map_bump", "map_opacity",
      "bump",   "disp",   "decal",  "refl",   "norm",    "Km"};
  return kStatements;
}

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

// Whether the word ends with the extension of an image.
bool IsImageName(std::string_view word) {
  static const std::set<std::string> kImages{".png",  ".jpg", ".jpeg", ".bmp", ".tga", ".tif",
                                             ".tiff", ".gif", ".dds",  ".exr", ".hdr", ".webp"};
  return kImages.contains(LowerExtension(std::string(word)));
}

std::string Shown(std::string_view word) { return "'" + OneLine(std::string(word)) + "'"; }

bool IsKnown(std::string_view kind) {
  const auto& others = OtherStatements();
  return NumberStatements().contains(kind) ||
         std::find(others.begin(), others.end(), kind) != others.end();
}

// Names may have any encoding.
bool IsText(const std::string& line) {
  return std::none_of(line.begin(), line.end(),
                      [](unsigned char c) { return std::iscntrl(c) && c != '\t' && c != '\r'; });
}

std::string FaultOfNumbers(const Words& words, const Numbers& form) {
  const size_t count = words.size() - 1;
  if (count < form.fewest || count > form.limit) {
    return fmt::format("has {} number{}", count, count == 1 ? "" : "s");
  }
  for (size_t i = 1; i < words.size(); ++i) {
    const std::optional<double> value = NumberIn(words[i]);
    if (!value) return Shown(words[i]) + " is no number";
    if (!(*value >= form.min && *value <= form.max)) {
      return fmt::format("has {} for {}, which is not within {} and {}", *value, words[0], form.min,
                         std::floor(form.max));
    }
  }
  return "";
}

// The fault of a statement; empty = none.
std::string FaultOf(const Words& words) {
  const std::string_view kind = words.front();
  if (!IsKeyword(kind)) return fmt::format("begins with {}, which is no word", Shown(kind));
  if (const auto known = NumberStatements().find(kind); known != NumberStatements().end()) {
    return FaultOfNumbers(words, known->second);
  }
  const auto& others = OtherStatements();
  if (std::find(others.begin(), others.end(), kind) != others.end()) {
    return words.size() > 1 ? "" : fmt::format("has nothing after {}", kind);
  }
  // Statements of other programs have three letters or more and no digits. If they name a texture,
  // they begin with map_.
  std::vector<std::string> all = others;
  for (const auto& [name, form] : NumberStatements()) all.emplace_back(name);
  const std::string near = NearestName(kind, all);
  const bool names_texture = words.size() > 1 && IsImageName(words.back());
  const bool is_of_others = kind.size() > 2 && std::none_of(kind.begin(), kind.end(), IsDigit) &&
                            (!names_texture || kind.starts_with("map_"));
  if (is_of_others && near.empty()) return "";
  return fmt::format("begins with the unknown word {}{}", Shown(kind),
                     near.empty() ? "" : "; did you mean " + near + "?");
}

// Returns the rest of a line after its first word, without spaces around it.
std::string RestOf(const std::string& line, std::string_view word) {
  const size_t from = line.find_first_not_of(" \t\r", line.find(word) + word.size());
  if (from == std::string::npos) return "";
  return line.substr(from, line.find_last_not_of(" \t\r") + 1 - from);
}

// Returns the names after a word at the begin of lines, with the numbers of their first lines.
std::map<std::string, size_t> NamesAfter(const std::filesystem::path& path, std::string_view word) {
  std::map<std::string, size_t> names;
  std::ifstream file(path, std::ios::binary);
  size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (line.find(word) == std::string::npos) continue;  // most lines, unsplit
    const Words words = WordsOf(line);
    if (!words.empty() && words.front() == word) names.emplace(RestOf(line, word), number);
  }
  return names;
}

// Names with which programs say that a face has no material.
bool IsNoMaterial(const std::string& name) {
  return name.empty() || name == "None" || name == "none" || name == "(null)" || name == "default";
}

// Whether the last line, which has no line end, may be cut: it begins a material, has a word
// without values or one that is unknown, or names a texture that is not there and has no extension
// of an image.
bool IsCutIn(const std::string& line, const std::filesystem::path& material) {
  const Words words = WordsOf(line);
  if (words.empty()) return false;
  if (words.front() == "newmtl" || words.size() == 1) return true;
  if (!words.front().starts_with("map_")) return !IsKnown(words.front());
  const std::filesystem::path texture = std::string(words.back());
  std::error_code error;
  return !IsImageName(words.back()) &&
         !std::filesystem::exists(material.parent_path() / texture.filename(), error);
}

}  // namespace

void CheckMaterials(const std::filesystem::path& mesh,
                    const std::set<std::filesystem::path>& files) {
  std::map<std::string, size_t> materials;
  bool all_exist = true;
  for (const std::filesystem::path& file : files) {
    if (LowerExtension(file) != ".mtl") continue;
    CheckMaterialFile(mesh, file);
    all_exist &= std::filesystem::exists(file);
    materials.merge(NamesAfter(file, "newmtl"));
  }
  if (!all_exist || materials.empty() || LowerExtension(mesh) != ".obj") return;
  for (const auto& [name, line] : NamesAfter(mesh, "usemtl")) {
    if (IsNoMaterial(name) || materials.contains(name)) continue;
    RefuseUnreadable(mesh, fmt::format("line {} uses the material {}, which its material file does "
                                       "not have",
                                       line, Shown(name)));
  }
}

void CheckMaterialFile(const std::filesystem::path& mesh, const std::filesystem::path& material) {
  std::ifstream file(material, std::ios::binary);
  if (file && file.peek() == std::ifstream::traits_type::eof()) {
    RefuseUnreadable(mesh, fmt::format("its material file '{}' is empty", material.string()));
  }
  size_t number = 0;
  bool has_material = false;
  std::set<std::string, std::less<>> kinds;  // statements of the current material
  for (std::string line; std::getline(file, line);) {
    ++number;
    if (file.eof() && IsCutIn(line, material)) {
      RefuseUnreadable(mesh,
                       fmt::format("line {} of its material file '{}' has no end, so the file "
                                   "may be cut short",
                                   number, material.string()));
    }
    const Words words = WordsOf(line);
    if (words.empty()) continue;
    std::string fault = FaultOf(words);
    if (fault.empty() && !IsText(line)) fault = "has bytes that are no text";
    if (words.front() == "newmtl") {
      has_material = true;
      kinds.clear();
    }
    if (fault.empty() && !has_material) fault = "is before the first newmtl";
    const bool is_repeatable = words.front() == "refl";  // one for each side of a cube
    if (!kinds.emplace(words.front()).second && fault.empty() && !is_repeatable) {
      fault = fmt::format("has {} for the second time; keep one", words.front());
    }
    if (fault.empty()) continue;
    RefuseUnreadable(mesh, fmt::format("line {} of its material file '{}' {}", number,
                                       material.string(), fault));
  }
}

}  // namespace pickbed::scenes
