#pragma once

// Numbers in text files of meshes.

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <string_view>

namespace pickbed::scenes {

// Returns the number that is the whole word, infinity for one beyond all numbers, and nothing for
// another word. A sign + is allowed. More than 19 digits before the point are no number, because
// assimp misreads them.
inline std::optional<double> NumberIn(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  constexpr size_t kMaxDigits = 19;
  const std::string_view digits = word.substr(word.starts_with('-') ? 1 : 0);
  if (std::min(digits.find_first_not_of("0123456789"), digits.size()) > kMaxDigits) {
    return std::nullopt;
  }
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [after, error] = std::from_chars(word.data(), end, value);
  if (after != end || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc() ? value : std::numeric_limits<double>::infinity();
}

}  // namespace pickbed::scenes
