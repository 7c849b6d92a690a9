#include "eval/frames/ply_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string_view>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

struct Property {
  std::string name;
  std::string type;
  bool is_list = false;
};

struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  bool is_ascii = false;
  std::vector<Element> elements;
  int width = 0, height = 0;
  size_t end = 0;  // first byte of the data
};

int SizeOf(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "int32" || type == "uint32") return 4;
  if (type == "float" || type == "float32") return 4;
  if (type == "double" || type == "float64") return 8;
  return 0;
}

bool IsFloat(const std::string& type) {
  return type.starts_with("float") || type.starts_with("double");
}

template <typename T>
double As(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof(value));
  return static_cast<double>(value);
}

double BinaryValue(const char* at, const std::string& type) {
  if (IsFloat(type)) return SizeOf(type) == 4 ? As<float>(at) : As<double>(at);
  const bool is_unsigned = type.starts_with("u");
  switch (SizeOf(type)) {
    case 1:
      return is_unsigned ? As<uint8_t>(at) : As<int8_t>(at);
    case 2:
      return is_unsigned ? As<uint16_t>(at) : As<int16_t>(at);
    default:
      return is_unsigned ? As<uint32_t>(at) : As<int32_t>(at);
  }
}

// Whether the number is a whole one of this integer type.
bool IsInteger(double value, const std::string& type) {
  const bool is_unsigned = type.starts_with("u");
  const double values = std::exp2(8 * SizeOf(type));
  const double first = is_unsigned ? 0 : -values / 2;
  return value >= first && value < first + values && value == std::floor(value);
}

void ReadSize(std::istringstream& line, PlyHeader& header) {
  std::string key;
  int value = 0;
  if (!(line >> key >> value) || value <= 0) return;
  if (key == "num_cols" || key == "width") header.width = value;
  if (key == "num_rows" || key == "height") header.height = value;
}

PlyHeader ReadHeader(const std::string& bytes, const std::string& name) {
  PlyHeader header;
  const auto require = [&](bool ok, const std::string& what) {
    CheckInput(ok, name + ": " + what);
  };
  require(bytes.starts_with("ply"), "the file is no PLY file; give another file");
  for (std::string key; key != "end_header";) {
    const size_t end = bytes.find('\n', header.end);
    require(end != std::string::npos, "the PLY header does not end; get the file again");
    std::istringstream line(bytes.substr(header.end, end - header.end));
    header.end = end + 1;
    key.clear();  // of a blank line
    line >> key;
    if (key == "format") {
      std::string format;
      line >> format;
      require(format == "ascii" || format == "binary_little_endian",
              "the format is " + format + "; write it as binary_little_endian or ascii");
      header.is_ascii = format == "ascii";
    } else if (key == "element") {
      Element element;
      line >> element.name >> element.count;
      header.elements.push_back(element);
    } else if (key == "property") {
      Property property;
      line >> property.type;
      property.is_list = property.type == "list";
      std::string count_type;
      if (property.is_list) line >> count_type >> property.type;
      line >> property.name;
      require(!header.elements.empty() && (property.is_list || SizeOf(property.type) > 0),
              "the property " + property.name + " has the unknown type " + property.type);
      std::vector<Property>& others = header.elements.back().properties;
      const bool is_new = std::none_of(others.begin(), others.end(), [&](const Property& other) {
        return other.name == property.name;
      });
      require(is_new, "the header names the property " + OneLine(property.name) +
                          " twice; get the file again");
      others.push_back(property);
    } else if (key == "comment" || key == "obj_info") {
      ReadSize(line, header);
    } else if (!key.empty() && key != "ply") {
      require(key == "end_header", "the header has the line '" + OneLine(line.str()) +
                                       "', which is no statement of PLY; get the file again");
    }
  }
  return header;
}

// Reads the numbers of the data one after another.
class Numbers {
 public:
  Numbers(const std::string& bytes, const PlyHeader& header, const std::string& name)
      : at_(bytes.data() + header.end),
        end_(bytes.data() + bytes.size()),
        is_ascii_(header.is_ascii),
        name_(name) {}

  double Next(const std::string& type) {
    if (is_ascii_) return NextWord(type);
    const int size = SizeOf(type);
    Require(end_ - at_ >= size);
    const double value = BinaryValue(at_, type);
    at_ += size;
    return value;
  }

 private:
  static bool IsSpace(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  double NextWord(const std::string& type) {
    while (at_ < end_ && IsSpace(*at_)) ++at_;
    double value = 0;
    const auto [after, error] = std::from_chars(at_, end_, value);
    Require(error == std::errc() && (after == end_ || IsSpace(*after)));
    CheckInput(IsFloat(type) || IsInteger(value, type),
               fmt::format("{}: the PLY file has the number {} of the type {}; get it again", name_,
                           std::string_view(at_, after), type));
    at_ = after;
    return value;
  }
  void Require(bool ok) const {
    CheckInput(ok, name_ + ": the PLY file is too short or damaged; get it again");
  }

  const char* at_;
  const char* end_;
  bool is_ascii_;
  const std::string& name_;
};

}  // namespace

PlyRows ReadPlyRows(const std::string& bytes, const std::string& name) {
  const PlyHeader header = ReadHeader(bytes, name);
  PlyRows ply;
  ply.width = header.width;
  ply.height = header.height;
  Numbers numbers(bytes, header, name);
  bool has_vertices = false;
  for (const Element& element : header.elements) {
    const bool is_vertex = element.name == "vertex", is_camera = element.name == "camera";
    // Only the camera that PCL writes behind the points is of use.
    if (has_vertices && !is_camera) break;
    for (const Property& property : element.properties) {
      CheckInput(!property.is_list,
                 fmt::format("{}: the element {} has a list before the points; write a cloud "
                             "without faces",
                             name, element.name));
      if (is_vertex) ply.columns.push_back({property.name, IsFloat(property.type), {}});
    }
    const auto size_from = [&](double value) {
      constexpr double kLargest = 1e6;
      CheckInput(value >= 0 && value <= kLargest && value == std::floor(value),
                 fmt::format("{}: the camera has a viewport of {:g} points; get the file again",
                             name, value));
      return static_cast<int>(value);
    };
    // A damaged count must not reserve memory.
    CheckInput(element.count <= bytes.size(),
               name + ": the PLY file is too short or damaged; get it again");
    for (size_t row = 0; row < element.count; ++row) {
      for (size_t i = 0; i < element.properties.size(); ++i) {
        const double value = numbers.Next(element.properties[i].type);
        if (is_vertex) ply.columns[i].values.push_back(value);
        if (is_camera && element.properties[i].name == "viewportx") {
          ply.width = size_from(value);
        }
        if (is_camera && element.properties[i].name == "viewporty") {
          ply.height = size_from(value);
        }
      }
    }
    if (!is_vertex) continue;
    has_vertices = true;
    ply.rows = element.count;
  }
  CheckInput(has_vertices, name + ": the PLY file has no points; give an organised cloud");
  return ply;
}

}  // namespace pickbed::eval
