#include "scenes/base/parallel.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace pickbed::scenes {

void ForRanges(int count, int threads, const std::function<void(int begin, int end)>& work) {
  const int ranges = std::clamp(threads, 1, std::max(count, 1));
  if (ranges == 1) {
    if (count > 0) work(0, count);
    return;
  }
  const auto start = [&](int range) {
    return static_cast<int>(static_cast<int64_t>(count) * range / ranges);
  };
  std::vector<std::exception_ptr> errors(ranges);
  const auto run = [&](int range) {
    try {
      work(start(range), start(range + 1));
    } catch (...) {
      errors[range] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (int range = 1; range < ranges; ++range) others.emplace_back(run, range);
    run(0);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace pickbed::scenes
