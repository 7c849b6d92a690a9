#include "scenes/mesh_io/ply_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/number_words.h"

namespace pickbed::scenes {
namespace {

struct Range {
  double min, max;
};

struct Property {
  std::string name;
  std::string type;
  std::string count_type;  // of a list; empty for a single value
};

struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;
};

enum class Form { kOther, kText, kLittleEndian, kBigEndian };

struct Header {
  Form form = Form::kOther;
  std::vector<Element> elements;
};

Form FormNamed(const std::string& name) {
  if (name == "ascii") return Form::kText;
  if (name == "binary_little_endian") return Form::kLittleEndian;
  return name == "binary_big_endian" ? Form::kBigEndian : Form::kOther;
}

// Bytes of a value in a binary file.
size_t BytesOf(const std::string& type) {
  if (type == "double" || type == "float64") return 8;
  if (type.ends_with("char") || type.ends_with("int8")) return 1;
  if (type.ends_with("short") || type.ends_with("int16")) return 2;
  return 4;
}

// The range of an integer type. Other types have none.
std::optional<Range> RangeOf(const std::string& type) {
  static const std::map<std::string, Range> kRanges = {{"char", {-128, 127}},
                                                       {"int8", {-128, 127}},
                                                       {"uchar", {0, 255}},
                                                       {"uint8", {0, 255}},
                                                       {"short", {-32768, 32767}},
                                                       {"int16", {-32768, 32767}},
                                                       {"ushort", {0, 65535}},
                                                       {"uint16", {0, 65535}},
                                                       {"int", {-2147483648., 2147483647.}},
                                                       {"int32", {-2147483648., 2147483647.}},
                                                       {"uint", {0, 4294967295.}},
                                                       {"uint32", {0, 4294967295.}}};
  const auto found = kRanges.find(type);
  return found == kRanges.end() ? std::nullopt : std::optional(found->second);
}

bool IsType(const std::string& type) {
  return RangeOf(type) || type == "float" || type == "float32" || type == "double" ||
         type == "float64";
}

// Whether the word can be a name: printable ASCII that begins with a letter or an underscore.
bool IsName(const std::string& word) {
  return !word.empty() &&
         (std::isalpha(static_cast<unsigned char>(word.front())) != 0 || word.front() == '_') &&
         std::all_of(word.begin(), word.end(), [](char c) { return c > ' ' && c <= '~'; });
}

// One line of an element, with its number in the file.
class Row {
 public:
  Row(const std::filesystem::path& path, size_t number, const std::string& line)
      : path_(path), number_(number), at_(line.data()), end_(line.data() + line.size()) {}

  // Returns the next value, which must be one of the type.
  double Next(const std::string& name, const std::string& type) {
    SkipSpace();
    const char* word = at_;
    while (at_ < end_ && !IsSpace(*at_)) ++at_;
    if (word == at_) Refuse("has no value for " + name);
    const std::string text = OneLine(std::string(word, at_));
    const std::optional<double> value = NumberIn({word, static_cast<size_t>(at_ - word)});
    if (!value) Refuse(fmt::format("has '{}' for {}, which is no number", text, name));
    const std::optional<Range> range = RangeOf(type);
    if (range && !(*value >= range->min && *value <= range->max && *value == std::floor(*value))) {
      Refuse(fmt::format("has {} for {}, but the type {} has whole numbers from {} to {}", text,
                         name, type, range->min, range->max));
    }
    return *value;
  }
  void RequireEnd() {
    SkipSpace();
    if (at_ < end_) Refuse("has more values than the header names");
  }

 private:
  static bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  void SkipSpace() {
    while (at_ < end_ && IsSpace(*at_)) ++at_;
  }
  [[noreturn]] void Refuse(const std::string& what) const {
    RefuseUnreadable(path_, fmt::format("line {} {}", number_, what));
  }

  const std::filesystem::path& path_;
  size_t number_;
  const char* at_;
  const char* end_;
};

void CheckRow(const Element& element, Row row) {
  for (const Property& property : element.properties) {
    double values = 1;
    if (!property.count_type.empty()) values = row.Next(property.name, property.count_type);
    for (; values > 0; --values) row.Next(property.name, property.type);
  }
  row.RequireEnd();
}

// The values of a binary file, one after another.
class BinaryValues {
 public:
  BinaryValues(const std::filesystem::path& path, std::string bytes, bool is_big_endian)
      : path_(path), bytes_(std::move(bytes)), is_big_endian_(is_big_endian) {}

  void Skip(const Element& element) {
    size_t size = 0;
    bool has_lists = false;
    for (const Property& property : element.properties) {
      size += BytesOf(property.type);
      has_lists |= !property.count_type.empty();
    }
    if (!has_lists) return SkipBytes(element, element.count, size);
    for (size_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        size_t values = 1;
        if (!property.count_type.empty()) values = TakeCount(element, property.count_type);
        SkipBytes(element, values, BytesOf(property.type));
      }
    }
  }
  void RequireEnd() const {
    if (at_ == bytes_.size()) return;
    RefuseUnreadable(path_,
                     fmt::format("it has {} bytes after its last element", bytes_.size() - at_));
  }

 private:
  void SkipBytes(const Element& element, size_t count, size_t size) {
    if (size > 0 && count > (bytes_.size() - at_) / size) {
      RefuseUnreadable(path_,
                       fmt::format("it ends within its elements '{}'", OneLine(element.name)));
    }
    at_ += count * size;
  }
  size_t TakeCount(const Element& element, const std::string& type) {
    const size_t begin = at_, size = BytesOf(type);
    SkipBytes(element, 1, size);
    uint64_t count = 0;
    for (size_t i = 0; i < size; ++i) {
      const size_t place = is_big_endian_ ? i : size - 1 - i;
      count = count << 8 | static_cast<unsigned char>(bytes_[begin + place]);
    }
    const bool is_signed = RangeOf(type)->min < 0;
    if (is_signed && (count >> (8 * size - 1)) != 0) {
      RefuseUnreadable(path_, fmt::format("a list of its elements '{}' has a negative size",
                                          OneLine(element.name)));
    }
    return count;
  }

  const std::filesystem::path& path_;
  std::string bytes_;
  bool is_big_endian_;
  size_t at_ = 0;
};

// Some properties of a vertex belong together. If one of them is missing, its name is damaged.
void RequireWholeGroups(const std::filesystem::path& path, const Element& element) {
  if (element.name != "vertex") return;
  for (const auto& group : {std::array{"x", "y", "z"}, std::array{"nx", "ny", "nz"},
                            std::array{"red", "green", "blue"}}) {
    std::string found, missing;
    for (const char* name : group) {
      const bool is_there =
          std::any_of(element.properties.begin(), element.properties.end(),
                      [&](const Property& property) { return property.name == name; });
      (is_there ? found : missing) = name;
    }
    if (found.empty() || missing.empty()) continue;
    RefuseUnreadable(path, fmt::format("its elements '{}' have a property '{}' but none '{}'",
                                       OneLine(element.name), found, missing));
  }
}

// Reads the header.
Header ReadHeader(const std::filesystem::path& path, std::ifstream& file, size_t& line_number) {
  Header header;
  std::vector<Element>& elements = header.elements;
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "end_header" || (line_number == 1 && key != "ply")) break;
    if (key == "format") {
      std::string version;
      words >> key >> version;
      header.form = FormNamed(key);
      if (header.form == Form::kOther) {
        RefuseUnreadable(path, fmt::format("it has the unknown format '{}'", OneLine(key)));
      }
      if (version != "1.0") {
        RefuseUnreadable(path, fmt::format("it has the version '{}' of PLY, which is not 1.0",
                                           OneLine(version)));
      }
    } else if (key == "element") {
      Element element;
      words >> element.name >> element.count;
      elements.push_back(element);
    } else if (key == "property" && !elements.empty()) {
      Property property;
      words >> property.type;
      if (property.type == "list") words >> property.count_type >> property.type;
      words >> property.name;
      if (!IsName(property.name)) {
        RefuseUnreadable(path, fmt::format("line {} has no name of a property: '{}'", line_number,
                                           OneLine(line)));
      }
      const bool is_list = !property.count_type.empty();
      if (!IsType(property.type) || (is_list && !RangeOf(property.count_type))) {
        RefuseUnreadable(
            path, fmt::format("line {} has an unknown type: '{}'", line_number, OneLine(line)));
      }
      const auto& others = elements.back().properties;
      if (std::any_of(others.begin(), others.end(),
                      [&](const Property& other) { return other.name == property.name; })) {
        RefuseUnreadable(path, fmt::format("line {} names the property '{}' again", line_number,
                                           OneLine(property.name)));
      }
      elements.back().properties.push_back(property);
    } else if (line_number > 1 && key != "comment" && key != "obj_info" && !key.empty()) {
      RefuseUnreadable(path, fmt::format("line {} of its header is no statement of PLY: '{}'",
                                         line_number, OneLine(line)));
    }
  }
  for (const Element& element : elements) RequireWholeGroups(path, element);
  return header;
}

bool IsBlank(const std::string& line) {
  return line.find_first_not_of(" \t\r") == std::string::npos;
}

void CheckText(const std::filesystem::path& path, const Header& header, std::ifstream& file,
               size_t line_number) {
  std::string line;
  for (const Element& element : header.elements) {
    for (size_t row = 0; row < element.count;) {
      ++line_number;
      if (!std::getline(file, line)) {
        RefuseUnreadable(path, fmt::format("its header names {} elements '{}', but it has {} lines "
                                           "of them",
                                           element.count, OneLine(element.name), row));
      }
      if (IsBlank(line)) continue;
      CheckRow(element, Row(path, line_number, line));
      ++row;
    }
  }
  while (std::getline(file, line)) {
    ++line_number;
    if (IsBlank(line)) continue;
    RefuseUnreadable(
        path, fmt::format("line {} is after its last element: '{}'", line_number, OneLine(line)));
  }
}

}  // namespace

void CheckPly(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  size_t line_number = 0;
  const Header header = ReadHeader(path, file, line_number);
  if (header.form == Form::kOther) return;
  if (header.form == Form::kText) return CheckText(path, header, file, line_number);
  std::string rest(std::istreambuf_iterator<char>(file), {});
  BinaryValues values(path, std::move(rest), header.form == Form::kBigEndian);
  for (const Element& element : header.elements) values.Skip(element);
  values.RequireEnd();
}

}  // namespace pickbed::scenes
