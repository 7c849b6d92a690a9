#include "scenes/mesh_io/ply_text_check.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
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

// Reads the header. Returns nothing for a binary file or another format.
std::vector<Element> ReadHeader(const std::filesystem::path& path, std::ifstream& file,
                                size_t& line_number) {
  std::vector<Element> elements;
  bool is_text = false;
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "end_header" || (line_number == 1 && key != "ply")) break;
    if (key == "format") {
      std::string version;
      words >> key >> version;
      is_text = key == "ascii";
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
      property.name = OneLine(property.name);
      const bool is_list = !property.count_type.empty();
      if (!IsType(property.type) || (is_list && !RangeOf(property.count_type))) {
        RefuseUnreadable(
            path, fmt::format("line {} has an unknown type: '{}'", line_number, OneLine(line)));
      }
      elements.back().properties.push_back(property);
    } else if (line_number > 1 && key != "comment" && key != "obj_info" && !key.empty()) {
      RefuseUnreadable(path, fmt::format("line {} of its header is no statement of PLY: '{}'",
                                         line_number, OneLine(line)));
    }
  }
  if (!is_text) elements.clear();
  return elements;
}

}  // namespace

void CheckPlyText(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  size_t line_number = 0;
  for (const Element& element : ReadHeader(path, file, line_number)) {
    std::string line;
    for (size_t row = 0; row < element.count;) {
      ++line_number;
      if (!std::getline(file, line)) {
        RefuseUnreadable(path, fmt::format("its header names {} elements '{}', but it has {} lines "
                                           "of them",
                                           element.count, OneLine(element.name), row));
      }
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      CheckRow(element, Row(path, line_number, line));
      ++row;
    }
  }
}

}  // namespace pickbed::scenes
