#include "scenes/mesh_io/collada_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"
#include "scenes/mesh_io/number_words.h"
#include "scenes/mesh_io/text_words.h"
#include "scenes/mesh_io/xml_elements.h"

namespace pickbed::scenes {
namespace {

std::optional<uint64_t> WholeNumber(std::string_view word) {
  uint64_t value = 0;
  const char* const end = word.data() + word.size();
  const auto [after, error] = std::from_chars(word.data(), end, value);
  return error == std::errc() && after == end && value < (uint64_t{1} << 32) ? std::optional(value)
                                                                             : std::nullopt;
}

class Checker {
 public:
  explicit Checker(const std::filesystem::path& path) : path_(path) {}

  void Check(const XmlElement& file) {
    if (file.name != "COLLADA") Refuse(file, "is no begin of a COLLADA file");
    const std::string version = file.Attribute("version");
    if (!version.starts_with("1.") || version.find_first_not_of("0123456789.") != version.npos) {
      Refuse(file, fmt::format("has the version '{}', which is none", OneLine(version)));
    }
    static const std::regex kNamespace("https?://www\\.collada\\.org/[0-9/]+/COLLADASchema");
    const std::string space = file.Attribute("xmlns");
    if (!space.empty() && !std::regex_match(space, kNamespace)) {
      Refuse(file, fmt::format("has the namespace '{}', which is none", OneLine(space)));
    }
    CollectGeometries(file);
    CheckAll(file);
  }

 private:
  [[noreturn]] void Refuse(const XmlElement& at, const std::string& what) const {
    RefuseUnreadable(path_, fmt::format("line {}: <{}> {}", at.line, OneLine(at.name), what));
  }
  uint64_t Count(const XmlElement& element, const std::string& attribute,
                 std::optional<uint64_t> otherwise = {}) const {
    const std::string value = element.Attribute(attribute);
    if (value.empty() && otherwise) return *otherwise;
    const std::optional<uint64_t> count = WholeNumber(value);
    if (!count) {
      Refuse(element,
             fmt::format("has '{}' for {}, which is no whole number", OneLine(value), attribute));
    }
    return *count;
  }

  void CollectGeometries(const XmlElement& element) {
    if (element.name == "geometry") geometries_.insert("#" + element.Attribute("id"));
    for (const XmlElement& child : element.children) CollectGeometries(child);
  }

  void CheckAll(const XmlElement& element) {
    static const std::map<std::string, size_t> kNumbers = {
        {"matrix", 16}, {"translate", 3}, {"rotate", 4}, {"scale", 3}, {"lookat", 9}};
    if (element.name == "mesh") CheckMesh(element);
    if (element.name == "node") {
      for (const XmlElement& child : element.children) {
        const auto known = kNumbers.find(child.name);
        if (known != kNumbers.end()) CheckNumbers(child, known->second, known->second);
        if (child.name != "instance_geometry") continue;
        const std::string url = child.Attribute("url");
        if (url.starts_with('#') && geometries_.contains(url)) continue;
        Refuse(child,
               fmt::format("names the geometry '{}', which the file does not have", OneLine(url)));
      }
    }
    if (element.name == "diffuse" || element.name == "ambient" || element.name == "specular") {
      if (const XmlElement* const color = element.Child("color")) CheckNumbers(*color, 3, 4);
    }
    if (element.name == "unit" && !element.Attribute("meter").empty()) {
      const std::optional<double> meter = NumberIn(element.Attribute("meter"));
      if (!meter || !(*meter > 0) || !std::isfinite(*meter)) {
        Refuse(element, fmt::format("has '{}' for meter, which is no length",
                                    OneLine(element.Attribute("meter"))));
      }
    }
    for (const XmlElement& child : element.children) CheckAll(child);
  }

  void CheckNumbers(const XmlElement& element, size_t fewest, size_t limit) const {
    const std::vector<std::string_view> words = WordsIn(element.text);
    if (words.size() < fewest || words.size() > limit) {
      Refuse(element, fmt::format("has {} numbers in place of {}", words.size(), fewest));
    }
    for (const std::string_view word : words) {
      const std::optional<double> value = NumberIn(word);
      if (value && std::isfinite(*value)) continue;
      Refuse(element, fmt::format("has '{}', which is no number", OneLine(std::string(word))));
    }
  }

  void CheckMesh(const XmlElement& mesh) const {
    for (const XmlElement& child : mesh.children) {
      if (child.name == "source") CheckSource(child);
      if (child.name == "triangles" || child.name == "polylist" || child.name == "polygons" ||
          child.name == "lines" || child.name == "linestrips" || child.name == "tristrips" ||
          child.name == "trifans") {
        CheckPrimitives(child);
      }
    }
  }

  void CheckSource(const XmlElement& source) const {
    for (const XmlElement& array : source.children) {
      if (!array.name.ends_with("_array")) continue;
      const uint64_t count = Count(array, "count");
      const std::vector<std::string_view> words = WordsIn(array.text);
      if (words.size() != count) {
        Refuse(array, fmt::format("has {} values, but names {}", words.size(), count));
      }
      if (array.name == "float_array") CheckNumbers(array, count, count);
      const XmlElement* const common = source.Child("technique_common");
      const XmlElement* const accessor = common ? common->Child("accessor") : nullptr;
      if (accessor == nullptr) continue;
      const uint64_t stride = Count(*accessor, "stride", 1);
      const uint64_t needed = Count(*accessor, "count") * stride + Count(*accessor, "offset", 0);
      if (needed > count) {
        Refuse(*accessor, fmt::format("takes {} values, but its array has {}", needed, count));
      }
      CheckParams(*accessor, stride);
    }
  }

  // Each value of a point, direction or color is a parameter. A matrix is one parameter of 16
  // values.
  void CheckParams(const XmlElement& accessor, uint64_t stride) const {
    constexpr uint64_t kMaxColorValues = 4;
    size_t params = 0;
    for (const XmlElement& child : accessor.children) {
      if (child.name != "param") continue;
      ++params;
      const std::string type = child.Attribute("type");
      if (std::ranges::all_of(
              type, [](unsigned char c) { return c == '_' || (c < 128 && std::isalnum(c)); })) {
        continue;
      }
      Refuse(child, fmt::format("has the type '{}', which is none", OneLine(type)));
    }
    if (params == 0 || stride > kMaxColorValues || params == stride) return;
    Refuse(accessor, fmt::format("has {} parameters, but a stride of {}", params, stride));
  }

  void CheckPrimitives(const XmlElement& primitives) const {
    const uint64_t count = Count(primitives, "count");
    uint64_t inputs = 0;  // indices of a corner
    uint64_t lists = 0, words = 0, corners = 0;
    for (const XmlElement& child : primitives.children) {
      if (child.name == "input") inputs = std::max(inputs, Count(child, "offset") + 1);
      if (child.name == "ph") ++lists;
      if (child.name == "p") {
        ++lists;
        const std::vector<std::string_view> indices = WordsIn(child.text);
        words += indices.size();
        for (const std::string_view index : indices) {
          if (WholeNumber(index)) continue;
          Refuse(child, fmt::format("has '{}', which is no index", OneLine(std::string(index))));
        }
      }
      if (child.name != "vcount") continue;
      const std::vector<std::string_view> sizes = WordsIn(child.text);
      if (sizes.size() != count) {
        Refuse(child, fmt::format("has {} numbers, but there are {} faces", sizes.size(), count));
      }
      for (const std::string_view size : sizes) {
        const std::optional<uint64_t> value = WholeNumber(size);
        if (!value) {
          Refuse(child,
                 fmt::format("has '{}', which is no whole number", OneLine(std::string(size))));
        }
        corners += *value;
      }
    }
    if (primitives.name == "triangles" || primitives.name == "lines") {
      corners = count * (primitives.name == "lines" ? 2 : 3);
    } else if (primitives.name != "polylist") {
      if (lists != count) {
        Refuse(primitives, fmt::format("has {} lists, but names {}", lists, count));
      }
      return;
    }
    if (words != corners * inputs) {
      Refuse(primitives, fmt::format("has {} indices, but needs {}", words, corners * inputs));
    }
  }

  const std::filesystem::path& path_;
  std::set<std::string> geometries_;
};

}  // namespace

void CheckCollada(const std::filesystem::path& path) {
  const std::string text = ReadFileBytes(path);
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) return;
  Checker(path).Check(ReadXml(path, text));
}

}  // namespace pickbed::scenes
