#include "scenes/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

class ForRangesTest : public ::testing::TestWithParam<int> {};

TEST_P(ForRangesTest, EachIndexIsProcessedOnce) {
  for (const int count : {0, 1, 2, 3, 100}) {
    std::vector<std::atomic<int>> visits(count);
    ForRanges(count, GetParam(), [&](int begin, int end) {
      for (int i = begin; i < end; ++i) ++visits[i];
    });
    for (int i = 0; i < count; ++i) EXPECT_EQ(visits[i], 1) << i << " of " << count;
  }
}

// All ranges end before an exception is rethrown, and it is the one of the first range.
TEST_P(ForRangesTest, FirstErrorIsRethrownAfterAllRangesEnd) {
  std::atomic<int> ended = 0;
  const auto work = [&](int begin, int end) {
    ended += end - begin;
    throw std::runtime_error(begin == 0 ? "first" : "later");
  };
  try {
    ForRanges(40, GetParam(), work);
    FAIL() << "threw no error";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "first");
  }
  EXPECT_EQ(ended, 40);
}

INSTANTIATE_TEST_SUITE_P(Threads, ForRangesTest, ::testing::Values(0, 1, 2, 7));

}  // namespace
}  // namespace pickbed::tests
