#include "scenes/base/message_text.h"

#include <fmt/format.h>

#include <cctype>
#include <cstdint>

namespace pickbed::scenes {

std::string OneLine(const std::string& text) {
  constexpr size_t kLongest = 80;
  std::string line;
  for (const char c : text) {
    const bool is_space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (is_space && (line.empty() || line.back() == ' ')) continue;
    line += is_space ? ' ' : c;
  }
  return line.size() <= kLongest ? line : line.substr(0, kLongest) + "...";
}

bool IsUtf8(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const auto first = static_cast<unsigned char>(text[at++]);
    if (first < 0x80) continue;
    const int more = first >= 0xf0 ? 3 : first >= 0xe0 ? 2 : 1;
    if (first < 0xc2 || first > 0xf4) return false;
    uint32_t code = first & (0x3fu >> more);
    for (int i = 0; i < more; ++i) {
      if (at == text.size()) return false;
      const auto next = static_cast<unsigned char>(text[at++]);
      if ((next & 0xc0) != 0x80) return false;
      code = code << 6 | (next & 0x3fu);
    }
    constexpr uint32_t kFewest[] = {0, 0x80, 0x800, 0x10000};
    const bool is_surrogate = code >= 0xd800 && code < 0xe000;
    if (code < kFewest[more] || code > 0x10ffff || is_surrogate) return false;
  }
  return true;
}

std::string Printable(const std::string& text) {
  const bool is_utf8 = IsUtf8(text);
  std::string printable;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    const bool is_plain = code < 0x80 ? code >= 0x20 && code != 0x7f : is_utf8;
    printable += !is_plain ? fmt::format("\\x{:02x}", code) : std::string(1, c);
  }
  return printable;
}

std::string Counted(size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

}  // namespace pickbed::scenes
