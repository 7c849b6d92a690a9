#pragma once

// Right check sums for the chunks of a mutated PNG.

#include <cstdint>
#include <string>
#include <string_view>

#include "scenes/image/image_check.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Gives the chunks of a mutated PNG right check sums, so that the decoder is reached. Other bytes
// stay as they are.
inline std::string WithRightCheckSums(std::string png) {
  constexpr size_t kHead = 8, kFrame = 12;
  if (!IsPng(png)) return png;
  const auto at = [&](size_t i) { return size_t{static_cast<unsigned char>(png[i])}; };
  for (size_t chunk = kHead; chunk + kFrame <= png.size();) {
    const size_t size = at(chunk) << 24 | at(chunk + 1) << 16 | at(chunk + 2) << 8 | at(chunk + 3);
    if (size > png.size() - chunk - kFrame) break;
    const size_t end = chunk + 8 + size;
    const uint32_t sum = PngCheckSum(std::string_view(png).substr(chunk + 4, 4 + size));
    for (int i = 0; i < 4; ++i) png[end + i] = static_cast<char>(sum >> (24 - 8 * i));
    chunk = end + 4;
  }
  return png;
}

}  // namespace pickbed::tests
