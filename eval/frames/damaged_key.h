#pragma once

// Keys in files of other programs. These may have any keys, but a damaged one hides its value.

#include <cstddef>
#include <string_view>

#include "eval/layer.h"

namespace pickbed::eval {

// Returns whether a key is a damaged or misspelled form of a known one: they have the same length
// and differ in one letter.
inline bool IsDamagedKey(std::string_view key, std::string_view known) {
  if (key.size() != known.size()) return false;
  int others = 0;
  for (size_t i = 0; i < key.size(); ++i) others += key[i] != known[i];
  return others == 1;
}

}  // namespace pickbed::eval
