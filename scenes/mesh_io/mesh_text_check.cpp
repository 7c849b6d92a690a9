#include "scenes/mesh_io/mesh_text_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"
#include "scenes/mesh_io/collada_check.h"
#include "scenes/mesh_io/gltf_check.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/number_words.h"
#include "scenes/mesh_io/ply_check.h"
#include "scenes/mesh_io/text_words.h"

namespace pickbed::scenes {
namespace {

namespace fs = std::filesystem;

// Whether the word is a corner of a face: 1, 1/2, 1//3 or 1/2/3, also negative.
bool IsCorner(std::string_view word) {
  for (int field = 0; field < 3; ++field) {
    const size_t end = std::min(word.find('/'), word.size());
    const std::string_view index = word.substr(0, end);
    int value = 0;
    const auto [after, error] = std::from_chars(index.data(), index.data() + index.size(), value);
    const bool is_index = error == std::errc() && after == index.data() + index.size();
    if (!is_index && !(index.empty() && field > 0)) return false;
    if (end == word.size()) return true;
    word.remove_prefix(end + 1);
  }
  return false;
}

// Whether the word can begin a statement. Programs have statements of their own, but only words.
bool IsStatement(std::string_view word) {
  return word == "curv2" || (IsKeyword(word) && std::none_of(word.begin(), word.end(), [](char c) {
                               return std::isdigit(static_cast<unsigned char>(c)) != 0;
                             }));
}

// Which of its indices a corner has: "1/2/3" gives "//", and "1//3" gives "-//".
std::string FormOf(std::string_view corner) {
  std::string form;
  for (size_t i = 0; i < corner.size(); ++i) {
    if (corner[i] == '/') form += i + 1 < corner.size() && corner[i + 1] == '/' ? "-/" : "/";
  }
  return form;
}

// Limits of the number of words after the first one.
struct WordLimits {
  size_t min = 1, max = SIZE_MAX;
};

// A vertex can have a weight or a color, or both.
WordLimits LimitsOf(std::string_view kind) {
  if (kind == "v") return {3, 7};
  if (kind == "vn") return {3, 3};
  if (kind == "vt") return {1, 3};
  return {kind == "l" ? 2u : 1u, SIZE_MAX};
}

// Checks the indices of faces into the lists of texture coordinates and normals. The importer
// checks the vertices, and leaves the others out.
class ObjIndices {
 public:
  // `number`: of the line.
  void Add(const std::vector<std::string_view>& words, size_t number) {
    if (words.empty()) return;
    if (words.front() == "vt") ++counts_[0];
    if (words.front() == "vn") ++counts_[1];
    if (words.front() != "f") return;
    for (size_t i = 1; i < words.size(); ++i) AddCorner(words[i], number);
  }
  // Returns the fault of the file; empty = none.
  std::string Fault() const {
    constexpr const char* kLists[] = {"texture coordinate", "normal"};
    for (int list = 0; list < 2; ++list) {
      if (largest_[list].index <= counts_[list]) continue;
      return fmt::format("line {} has a face with {} {}, but the file has {}", largest_[list].line,
                         kLists[list], largest_[list].index, counts_[list]);
    }
    return "";
  }

 private:
  struct Largest {
    int64_t index = 0;
    size_t line = 0;
  };
  void AddCorner(std::string_view corner, size_t number) {
    for (int list = -1; list < 2; ++list) {
      const size_t end = std::min(corner.find('/'), corner.size());
      int64_t index = 0;
      std::from_chars(corner.data(), corner.data() + end, index);
      // A negative index counts back from the last element so far.
      if (list >= 0 && std::abs(index) > largest_[list].index) {
        largest_[list] = {std::abs(index), number};
      }
      if (end == corner.size()) return;
      corner.remove_prefix(end + 1);
    }
  }

  std::array<int64_t, 2> counts_{};
  std::array<Largest, 2> largest_{};
};

// The words of a text STL, one after another.
class StlWords {
 public:
  StlWords(const fs::path& path, std::istream& file) : path_(path), file_(file) {}

  // Returns the next word in lower case; empty at the end.
  std::string Next() {
    std::string word;
    file_ >> word;
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return word;
  }
  void Expect(const char* expected) {
    const std::string word = Next();
    if (word != expected) Refuse(word, expected);
  }
  void ExpectNumbers() {
    for (int i = 0; i < 3; ++i) {
      const std::string word = Next();
      if (!NumberIn(word)) Refuse(word, "number");
    }
  }
  void SkipLine() {
    std::string rest;
    std::getline(file_, rest);
  }
  // Some programs write "nan" for the normal of a facet without area.
  void ExpectNormal() {
    for (int i = 0; i < 3; ++i) {
      const std::string word = Next();
      const std::optional<double> value = NumberIn(word);
      if (!value || std::isinf(*value)) Refuse(word, "number");
    }
  }
  void ReadFacet() {
    Expect("normal");
    ExpectNormal();
    Expect("outer");
    Expect("loop");
    for (int corner = 0; corner < 3; ++corner) {
      Expect("vertex");
      ExpectNumbers();
    }
    Expect("endloop");
    Expect("endfacet");
    ++facet_;
  }
  [[noreturn]] void Refuse(const std::string& word, const std::string& expected) const {
    RefuseUnreadable(
        path_, fmt::format("facet {} has '{}' in place of {}", facet_, OneLine(word), expected));
  }

 private:
  const fs::path& path_;
  std::istream& file_;
  int facet_ = 0;
};

bool IsBinaryStl(const fs::path& path, std::istream& file) {
  constexpr size_t kName = 80, kFace = 50;
  std::array<char, kName + sizeof(uint32_t)> head{};
  file.read(head.data(), head.size());
  const bool is_whole = static_cast<bool>(file);
  file.clear();
  file.seekg(0);
  if (std::strncmp(head.data(), "solid", 5) != 0) return true;
  uint32_t faces = 0;
  std::memcpy(&faces, head.data() + kName, sizeof(faces));
  return is_whole && fs::file_size(path) == head.size() + kFace * faces;
}

}  // namespace

void CheckMeshText(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".obj") CheckObjText(path);
  if (extension == ".stl") CheckStlText(path);
  if (extension == ".ply") CheckPly(path);
  if (extension == ".dae") CheckCollada(path);
  if (extension == ".gltf" || extension == ".glb") CheckGltf(path);
}

std::string FaultOfObjLine(std::span<const std::string_view> words) {
  if (words.empty()) return "";
  const std::string_view kind = words.front();
  const auto shown = [](std::string_view word) { return "'" + OneLine(std::string(word)) + "'"; };
  if (!IsStatement(kind)) return fmt::format("begins with {}, which is no word", shown(kind));
  const bool has_numbers = kind == "v" || kind == "vn" || kind == "vt";
  if (!has_numbers && kind != "f" && kind != "l" && kind != "p") {
    // An added letter would drop a face. A statement 'fo' is an old name of 'f'.
    const std::span<const std::string_view> corners = words.subspan(1);
    if (kind.size() == 2 && kind.find('f') != kind.npos && kind != "fo" && corners.size() >= 3 &&
        std::ranges::all_of(corners, IsCorner)) {
      return fmt::format("begins with the unknown word {}; did you mean f?", shown(kind));
    }
    // Statements of other programs have names of their own.
    if (kind.size() < 4) return "";
    const std::string near = NearestName(kind, {"usemtl", "mtllib", "usemap", "maplib"});
    if (near.empty() || near == kind) return "";
    return fmt::format("begins with the unknown word {}; did you mean {}?", shown(kind), near);
  }
  for (size_t i = 1; i < words.size(); ++i) {
    if (has_numbers) {
      const auto number = NumberIn(words[i]);
      if (!number) return shown(words[i]) + " is no number";
      if (kind == "vt" && std::abs(*number) > kMaxTextureCoordinate) {
        return "has the texture coordinate " + shown(words[i]);
      }
      continue;
    }
    if (!IsCorner(words[i])) {
      return shown(words[i]) + (kind == "f" ? " is no corner of a face" : " is no corner");
    }
    if (FormOf(words[i]) != FormOf(words[1])) {
      return fmt::format("has corners of two forms, {} and {}", shown(words[1]), shown(words[i]));
    }
  }
  const size_t count = words.size() - 1;
  const WordLimits limits = LimitsOf(kind);
  if (count >= limits.min && count <= limits.max) return "";
  return fmt::format("has {} {} after {}", count, has_numbers ? "numbers" : "corners", shown(kind));
}

void CheckObjText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  bool continues = false;  // the line before ends with a backslash
  bool has_long_lines = false;
  ObjIndices indices;
  size_t number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    const std::vector<std::string_view> words = WordsOf(line);
    const bool is_continued = continues;
    continues = !words.empty() && words.back().ends_with('\\');
    has_long_lines |= continues;
    if (is_continued || continues) continue;
    const std::string fault = FaultOfObjLine(words);
    if (!fault.empty()) RefuseUnreadable(path, fmt::format("line {} {}", number, fault));
    indices.Add(words, number);
  }
  const std::string fault = has_long_lines ? "" : indices.Fault();
  if (!fault.empty()) RefuseUnreadable(path, fault);
}

void CheckStlText(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (IsBinaryStl(path, file)) return;
  StlWords words(path, file);
  for (std::string word = words.Next(); !word.empty(); word = words.Next()) {
    if (word == "facet") {
      words.ReadFacet();
    } else if (word == "solid" || word == "endsolid" || word == "color") {
      words.SkipLine();
    } else {
      words.Refuse(word, "facet or endsolid");
    }
  }
}

}  // namespace pickbed::scenes
