#include "scenes/base/message_text.h"

#include <fmt/format.h>

#include <cctype>

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

std::string Printable(const std::string& text) {
  std::string printable;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    printable += code < 0x20 || code == 0x7f ? fmt::format("\\x{:02x}", code) : std::string(1, c);
  }
  return printable;
}

}  // namespace pickbed::scenes
