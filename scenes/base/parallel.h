#pragma once

// Loops with independent iterations, distributed over threads.

#include <functional>

namespace pickbed::scenes {

// Splits 0..count into at most `threads` ranges and calls work(begin, end) for each on its own
// thread. For threads <= 1 it uses only the calling thread. Returns when all ranges are done. The
// result of an iteration must depend only on its index; results are then the same for any number of
// threads. Rethrows the exception of the first range that threw.
void ForRanges(int count, int threads, const std::function<void(int begin, int end)>& work);

}  // namespace pickbed::scenes
