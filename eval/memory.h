#pragma once

// Memory of this process as the kernel counts it, bytes of RAM.

#include <cstddef>

namespace pickbed {

// Gives memory that was freed but is still held for the next need back to the kernel, but for up to
// 64 MiB at the end of the heap of each thread: what is needed from here on shows in the peak,
// whoever needed as much before.
void ReleaseFreedMemory();
// Forgets the peak so far and says what is held now.
size_t ResetPeakMemory();
// The most that was held since ResetPeakMemory(), or since the start where the kernel does not let
// the peak be forgotten.
size_t PeakMemory();

}  // namespace pickbed
