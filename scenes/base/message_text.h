#pragma once

// Texts of files in messages. Files of others can hold anything, and a message has one line.

#include <string>

namespace pickbed::scenes {

// Returns the text in one line: line breaks become spaces, and what is longer than 80 characters is
// cut.
std::string OneLine(const std::string& text);

// Returns the text with control characters as \x1b and so on. A terminal would obey them.
std::string Printable(const std::string& text);

}  // namespace pickbed::scenes
