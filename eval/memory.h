#pragma once

// Memory of this process as the kernel counts it, bytes of RAM.

#include <cstddef>

namespace pickbed {

// Forgets the peak so far and says what is held now.
size_t ResetPeakMemory();
// The most that was held since ResetPeakMemory(), or since the start where the kernel does not let
// the peak be forgotten.
size_t PeakMemory();

}  // namespace pickbed
