#pragma once

// Words of text files of meshes.

#include <algorithm>
#include <cctype>
#include <string_view>
#include <vector>

namespace pickbed::scenes {

// Returns the words between spaces and line ends. The text must outlive them.
inline std::vector<std::string_view> WordsIn(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<std::string_view> words;
  for (size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    words.push_back(text.substr(at, end - at));
    at = text.find_first_not_of(kSpace, end);
  }
  return words;
}

// Returns the words of a line up to a comment, which begins with #. The line must outlive them.
inline std::vector<std::string_view> WordsOf(std::string_view line) {
  return WordsIn(line.substr(0, line.find('#')));
}

// Whether the word has only letters, digits, _ and -.
inline bool IsKeyword(std::string_view word) {
  return std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return c < 128 && (std::isalnum(c) != 0 || c == '_' || c == '-');
  });
}

}  // namespace pickbed::scenes
