#pragma once

// Sums of products with the same result on every x86-64 CPU, on plain arrays. Libraries select a
// kernel for the CPU that they find, and each kernel sums in another order.

#include <cstdint>

#include "perception/layer.h"

namespace pickbed::perception {

inline constexpr int64_t kSumRows = 4;                 // rows of a block
inline constexpr int64_t kSumLanes = 8;                // columns of half a block
inline constexpr int64_t kSumColumns = 2 * kSumLanes;  // columns of a block

// Rounds up to a multiple of `step`.
constexpr int64_t RoundedUp(int64_t value, int64_t step) {
  return (value + step - 1) / step * step;
}

// Factors of a block of sums. Term k of the sum in row r and column c is
// rows[r * terms + k] * left[offsets[k] + c] for c < kSumLanes, and
// rows[r * terms + k] * right[offsets[k] + c - kSumLanes] for the other columns.
struct SumBlock {
  const float* rows;
  const float* left;
  const float* right;
  const int64_t* offsets;
  int64_t terms;
};

// Adds the terms of each sum in the order of k, rounded after each product and each addition.
// `sums` is kSumRows x kSumColumns.
void AddProducts(const SumBlock& block, float* sums);

}  // namespace pickbed::perception
