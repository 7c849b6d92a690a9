#pragma once

#include <cstring>
#include <string>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Gives an edited file of BlockWriter a right check sum, so that the code behind the check is
// reached. A file without a whole head stays as it is.
inline std::string WithRightHash(std::string bytes) {
  constexpr size_t kHead = 24, kHashAt = 16;  // magic, version, check sum
  if (bytes.size() < kHead) return bytes;
  const uint64_t hash = HashBytes(bytes.data() + kHead, bytes.size() - kHead);
  std::memcpy(bytes.data() + kHashAt, &hash, sizeof hash);
  return bytes;
}

}  // namespace pickbed::tests
