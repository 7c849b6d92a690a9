#pragma once

// Elements of an XML file.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace pickbed::scenes {

struct XmlElement {
  std::string name;
  int line = 0;  // of its begin, from 1
  std::map<std::string, std::string> attributes;
  std::string text;  // of the element itself, without its children
  std::vector<XmlElement> children;

  // Returns the first child of this name, or null.
  const XmlElement* Child(const std::string& child) const;
  // Returns the value of an attribute, or an empty text.
  std::string Attribute(const std::string& attribute) const;
};

// Returns the outermost element of an XML text. Entities such as &lt; stay as they are. Throws
// InputError with the file and line if the text is no XML, if elements are nested more than 100
// deep, or if an element has an attribute twice.
XmlElement ReadXml(const std::filesystem::path& path, const std::string& text);

}  // namespace pickbed::scenes
