#include "scenes/mesh_io/xml_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <pugixml.hpp>
#include <string_view>

#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"

namespace pickbed::scenes {
namespace {

// Copies the elements of a parsed text. pugixml accepts repeated attributes, and several outermost
// elements with text between them.
class Copier {
 public:
  Copier(const std::filesystem::path& path, std::string_view text) : path_(path), text_(text) {}

  [[noreturn]] void Refuse(std::ptrdiff_t offset, const std::string& what) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + offset, '\n');
    RefuseUnreadable(path_, fmt::format("line {} {}", line, what));
  }

  // Other encodings are the importer's matter.
  void RequireUtf8(const pugi::xml_node& declaration) const {
    std::string encoding = declaration.attribute("encoding").value();
    for (char& c : encoding) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (!encoding.empty() && encoding != "utf-8" && encoding != "utf8") return;
    std::ptrdiff_t offset = 0;
    for (std::string_view rest = text_; !rest.empty();) {
      const std::string_view line = rest.substr(0, rest.find('\n'));
      if (!IsUtf8(line)) Refuse(offset, "is not UTF-8");
      const size_t length = std::min(line.size() + 1, rest.size());
      rest.remove_prefix(length);
      offset += static_cast<std::ptrdiff_t>(length);
    }
  }

  void CheckDeclaration(const pugi::xml_node& declaration) const {
    if (!declaration) return;
    const std::string version = declaration.attribute("version").value();
    if (version == "1.0" || version == "1.1") return;
    Refuse(declaration.offset_debug(),
           fmt::format("has the XML version '{}', which is none", OneLine(version)));
  }

  XmlElement Outermost(const pugi::xml_node& document) {
    const pugi::xml_node first = document.find_child(IsElement);
    if (!first) RefuseUnreadable(path_, "it has no element");
    for (const pugi::xml_node& node : document) {
      if (IsElement(node) && node != first) {
        Refuse(node.offset_debug(), "has an element after the end of the outermost one");
      }
      const std::string_view text = node.value();
      const size_t at = text.find_first_not_of(" \t\r\n");
      if (at == std::string_view::npos) continue;
      Refuse(node.offset_debug() + static_cast<std::ptrdiff_t>(at),
             "has text outside of the outermost element");
    }
    return Copy(first, 1);
  }

 private:
  static bool IsElement(const pugi::xml_node& node) { return node.type() == pugi::node_element; }

  // Is called in the order of the text.
  XmlElement Copy(const pugi::xml_node& node, int depth) {
    constexpr int kDeepest = 100;
    const std::ptrdiff_t offset = node.offset_debug();
    if (depth > kDeepest) Refuse(offset, "nests its elements more than 100 deep");
    line_ += static_cast<int>(std::count(text_.begin() + counted_, text_.begin() + offset, '\n'));
    counted_ = offset;
    XmlElement element{node.name(), line_, {}, {}, {}};
    for (const pugi::xml_attribute& attribute : node.attributes()) {
      if (element.attributes.emplace(attribute.name(), attribute.value()).second) continue;
      Refuse(offset, fmt::format("has the attribute '{}' twice", OneLine(attribute.name())));
    }
    for (const pugi::xml_node& child : node) {
      element.text += child.value();
      if (IsElement(child)) element.children.push_back(Copy(child, depth + 1));
    }
    return element;
  }

  const std::filesystem::path& path_;
  std::string_view text_;
  std::ptrdiff_t counted_ = 0;  // the lines before it are counted
  int line_ = 1;
};

}  // namespace

const XmlElement* XmlElement::Child(const std::string& child) const {
  const auto found = std::find_if(children.begin(), children.end(),
                                  [&](const XmlElement& c) { return c.name == child; });
  return found == children.end() ? nullptr : &*found;
}

std::string XmlElement::Attribute(const std::string& attribute) const {
  const auto found = attributes.find(attribute);
  return found == attributes.end() ? "" : found->second;
}

XmlElement ReadXml(const std::filesystem::path& path, const std::string& text) {
  constexpr unsigned kFlags =
      pugi::parse_minimal | pugi::parse_fragment | pugi::parse_ws_pcdata | pugi::parse_declaration;
  Copier copier(path, text);
  // pugixml takes it for the end.
  const size_t zero = text.find('\0');
  if (zero != std::string::npos) {
    copier.Refuse(static_cast<std::ptrdiff_t>(zero), "has a byte of value 0");
  }
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer(text.data(), text.size(), kFlags, pugi::encoding_utf8);
  if (!result) {
    copier.Refuse(result.offset, fmt::format("cannot be read: {}", result.description()));
  }
  const pugi::xml_node declaration = document.find_child(
      [](const pugi::xml_node& node) { return node.type() == pugi::node_declaration; });
  copier.CheckDeclaration(declaration);
  copier.RequireUtf8(declaration);
  return copier.Outermost(document);
}

}  // namespace pickbed::scenes
