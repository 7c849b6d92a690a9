#include "scenes/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace pickbed {
namespace {

class ForRangesOf : public ::testing::TestWithParam<int> {};

TEST_P(ForRangesOf, EachTurnIsTakenOnce) {
  for (const int count : {0, 1, 2, 3, 100}) {
    std::vector<std::atomic<int>> taken(count);
    ForRanges(count, GetParam(), [&](int begin, int end) {
      for (int i = begin; i < end; ++i) ++taken[i];
    });
    for (int i = 0; i < count; ++i) EXPECT_EQ(taken[i], 1) << i << " of " << count;
  }
}

// All ranges end before an error of one comes out, and the first range's is the one.
TEST_P(ForRangesOf, AnErrorComesOutWhenAllAreDone) {
  std::atomic<int> ended = 0;
  const auto work = [&](int begin, int end) {
    ended += end - begin;
    throw std::runtime_error(begin == 0 ? "first" : "later");
  };
  try {
    ForRanges(40, GetParam(), work);
    FAIL() << "no error came out";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "first");
  }
  EXPECT_EQ(ended, 40);
}

INSTANTIATE_TEST_SUITE_P(Threads, ForRangesOf, ::testing::Values(0, 1, 2, 7));

}  // namespace
}  // namespace pickbed
