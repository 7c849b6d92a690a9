#pragma once

// Loops whose turns are independent, spread over threads.

#include <functional>

namespace pickbed {

// Calls work(begin, end) for ranges that make up 0..count, one a thread at most; on the calling
// thread alone for threads <= 1. Returns when all are done. What a turn computes must depend on its
// index alone, so that results are the same for any number of threads. Throws what a range threw,
// the first range's if several did.
void ForRanges(int count, int threads, const std::function<void(int begin, int end)>& work);

}  // namespace pickbed
