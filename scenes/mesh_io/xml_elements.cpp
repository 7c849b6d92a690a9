#include "scenes/mesh_io/xml_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "scenes/base/message_text.h"
#include "scenes/mesh_io/mesh_file_check.h"

namespace pickbed::scenes {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::string_view text) : path_(path), text_(text) {}

  XmlElement Read() {
    XmlElement outermost;
    std::vector<XmlElement*> open;
    bool is_done = false;
    while (at_ < text_.size()) {
      const size_t tag = std::min(text_.find('<', at_), text_.size());
      const std::string_view text = text_.substr(at_, tag - at_);
      if (!open.empty()) {
        open.back()->text += text;
      } else if (text.find_first_not_of(kSpace) != std::string_view::npos && !IsByteOrder(text)) {
        Refuse("has text outside of the outermost element");
      }
      at_ = tag;
      if (at_ == text_.size()) break;
      if (SkipMarkup()) continue;
      if (text_.substr(at_).starts_with("</")) {
        Close(open);
        is_done |= open.empty();
        continue;
      }
      if (is_done) Refuse("has an element after the end of the outermost one");
      constexpr size_t kDeepest = 100;
      if (open.size() >= kDeepest) Refuse("nests its elements more than 100 deep");
      if (!open.empty()) open.back()->children.emplace_back();
      XmlElement& element = open.empty() ? outermost : open.back()->children.back();
      const bool has_content = Begin(element);
      if (has_content) open.push_back(&element);
      is_done |= open.empty();
    }
    if (!open.empty()) {
      RefuseUnreadable(path_, fmt::format("it ends within its element '{}' of line {}",
                                          OneLine(open.back()->name), open.back()->line));
    }
    if (!is_done) RefuseUnreadable(path_, "it has no element");
    return outermost;
  }

 private:
  static bool IsByteOrder(std::string_view text) {
    return text.starts_with("\xef\xbb\xbf") &&
           text.find_first_not_of(kSpace, 3) == std::string_view::npos;
  }
  int Line() {
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(counted_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
    counted_ = at_;
    return line_;
  }
  [[noreturn]] void Refuse(const std::string& what) {
    RefuseUnreadable(path_, fmt::format("line {} {}", Line(), what));
  }
  // Skips comments, declarations and the like.
  bool SkipMarkup() {
    for (const auto& [begin, end] : {std::pair<std::string_view, std::string_view>{"<!--", "-->"},
                                     {"<![CDATA[", "]]>"},
                                     {"<?", "?>"},
                                     {"<!", ">"}}) {
      if (!text_.substr(at_).starts_with(begin)) continue;
      const size_t found = text_.find(end, at_ + begin.size());
      if (found == std::string_view::npos) Refuse(fmt::format("has no {} for its {}", end, begin));
      at_ = found + end.size();
      return true;
    }
    return false;
  }
  std::string Word(std::string_view ends) {
    const size_t end = std::min(text_.find_first_of(ends, at_), text_.size());
    std::string word(text_.substr(at_, end - at_));
    at_ = end;
    return word;
  }
  void SkipSpace() { at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size()); }
  bool Take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void Close(std::vector<XmlElement*>& open) {
    at_ += 2;
    const std::string name = Word(" \t\r\n>");
    SkipSpace();
    if (!Take('>') || open.empty() || open.back()->name != name) {
      Refuse(fmt::format("closes the element '{}', which is not open there", OneLine(name)));
    }
    open.pop_back();
  }
  // Reads a tag with its attributes. Returns whether the element has content.
  bool Begin(XmlElement& element) {
    ++at_;
    element.line = Line();
    element.name = Word(" \t\r\n/>");
    if (element.name.empty()) Refuse("has a tag without a name");
    for (;;) {
      SkipSpace();
      if (Take('>')) return true;
      if (Take('/')) {
        if (!Take('>')) Refuse(fmt::format("has a broken tag '{}'", OneLine(element.name)));
        return false;
      }
      const std::string name = Word(" \t\r\n=/>");
      SkipSpace();
      const bool has_value = !name.empty() && Take('=');
      SkipSpace();
      const char quote = at_ < text_.size() ? text_[at_] : ' ';
      if (!has_value || (quote != '"' && quote != '\'')) {
        Refuse(fmt::format("has an attribute of '{}' without a value", OneLine(element.name)));
      }
      ++at_;
      const std::string value = Word(std::string_view(&quote, 1));
      if (!Take(quote)) Refuse("has a value without its end");
      if (!element.attributes.emplace(name, value).second) {
        Refuse(fmt::format("has the attribute '{}' twice", OneLine(name)));
      }
    }
  }

  const std::filesystem::path& path_;
  std::string_view text_;
  size_t at_ = 0;
  size_t counted_ = 0;  // the lines before it are counted
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
  return Reader(path, text).Read();
}

}  // namespace pickbed::scenes
