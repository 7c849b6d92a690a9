#include "perception/networks/fixed_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

// Each sum equals a plain loop with volatile intermediate values, which has no wider and no fused
// arithmetic. The values differ so much in size that any other order of additions is seen.
TEST(AddProducts, AddsInOrderWithARoundingAfterEachStep) {
  constexpr int64_t kTerms = 57, kStep = 20;
  scenes::Rng rng(3);
  const auto random = [&](int64_t count) {
    std::vector<float> values(count);
    for (float& v : values) v = static_cast<float>(rng.Normal() * std::exp(3 * rng.Normal()));
    return values;
  };
  const std::vector<float> rows = random(kSumRows * kTerms), values = random(kTerms * kStep + 40);
  std::vector<int64_t> offsets(kTerms);
  for (int64_t k = 0; k < kTerms; ++k) offsets[k] = kStep * ((k * 7) % kTerms);
  std::vector<float> sums = random(kSumRows * kSumColumns);
  std::vector<float> expected = sums;
  const float *const left = values.data() + 3, *const right = values.data() + 17;
  for (int64_t r = 0; r < kSumRows; ++r) {
    for (int64_t c = 0; c < kSumColumns; ++c) {
      volatile float sum = expected[r * kSumColumns + c];
      for (int64_t k = 0; k < kTerms; ++k) {
        const float* const half = c < kSumLanes ? left + c : right + c - kSumLanes;
        volatile float product = rows[r * kTerms + k] * half[offsets[k]];
        sum = sum + product;
      }
      expected[r * kSumColumns + c] = sum;
    }
  }
  AddProducts({rows.data(), left, right, offsets.data(), kTerms}, sums.data());
  for (size_t i = 0; i < sums.size(); ++i) EXPECT_EQ(sums[i], expected[i]) << i;
}

TEST(AddProducts, NoTermsLeaveTheSums) {
  std::vector<float> sums(kSumRows * kSumColumns, 2.5f);
  const float none = 0;
  AddProducts({&none, &none, &none, nullptr, 0}, sums.data());
  for (const float sum : sums) EXPECT_EQ(sum, 2.5f);
}

TEST(RoundedUp, IsTheNextMultiple) {
  EXPECT_EQ(RoundedUp(0, 8), 0);
  EXPECT_EQ(RoundedUp(1, 8), 8);
  EXPECT_EQ(RoundedUp(8, 8), 8);
  EXPECT_EQ(RoundedUp(9, 8), 16);
}

}  // namespace
}  // namespace pickbed::perception
