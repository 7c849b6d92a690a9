#pragma once

// Texts of files in messages. Files of others can hold anything, and a message has one line.

#include <cstddef>
#include <string>
#include <string_view>

namespace pickbed::scenes {

// Returns the text in one line: line breaks become spaces, and what is longer than 80 characters is
// cut.
std::string OneLine(const std::string& text);

// Returns whether the text is valid UTF-8 (RFC 3629, section 4).
bool IsUtf8(std::string_view text);

// Returns the text with control characters as \x1b and so on. A terminal would obey them. All bytes
// over 0x7f of a text that is not UTF-8 are shown so, too.
std::string Printable(const std::string& text);

// Returns a number with its noun, "1 pose" or "2 poses". The plural must be the noun with an s.
std::string Counted(size_t count, const std::string& noun);

}  // namespace pickbed::scenes
