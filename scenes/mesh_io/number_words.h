#pragma once

// Numbers in text files of meshes.

#include <charconv>
#include <limits>
#include <optional>
#include <string_view>

namespace pickbed::scenes {

// Returns the number that is the whole word, infinity for one beyond all numbers, and nothing for
// another word. A sign + is allowed.
inline std::optional<double> NumberIn(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [after, error] = std::from_chars(word.data(), end, value);
  if (after != end || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc() ? value : std::numeric_limits<double>::infinity();
}

}  // namespace pickbed::scenes
