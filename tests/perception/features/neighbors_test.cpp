#include "perception/features/neighbors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kRowLength = 32;

// Unit vectors on a curved manifold of `dimensions` dimensions, similar to descriptors of poses.
std::vector<float> SmoothRows(int count, int dimensions, uint64_t seed) {
  Rng map_rng(99), rng(seed);
  std::vector<double> map(dimensions * kRowLength);
  for (double& value : map) value = map_rng.Normal();
  std::vector<float> rows;
  for (int i = 0; i < count; ++i) {
    std::vector<double> z(dimensions), row(kRowLength, 0);
    for (double& value : z) value = rng.Uniform(-1, 1);
    double squared = 0;
    for (int d = 0; d < kRowLength; ++d) {
      for (int j = 0; j < dimensions; ++j) row[d] += z[j] * map[j * kRowLength + d];
      row[d] = std::sin(row[d]);
      squared += row[d] * row[d];
    }
    for (const double value : row) rows.push_back(static_cast<float>(value / std::sqrt(squared)));
  }
  return rows;
}

double Recall(const Neighbors& found, const Neighbors& exact) {
  int hits = 0;
  for (size_t first = 0; first < exact.rows.size(); first += exact.k) {
    for (int i = 0; i < exact.k; ++i) {
      hits += std::count(found.rows.begin() + first, found.rows.begin() + first + exact.k,
                         exact.rows[first + i]);
    }
  }
  return static_cast<double>(hits) / static_cast<double>(exact.rows.size());
}

TEST(NeighborIndex, FindsNineOfTenNeighborsInOnePercentOfRows) {
  const std::vector<float> rows = SmoothRows(20000, 5, 1), queries = SmoothRows(300, 5, 2);
  NeighborOptions options;
  options.checks = 200;
  const NeighborIndex index(rows, kRowLength, options);
  EXPECT_GE(Recall(index.Search(queries, 8), SearchExactly(rows, queries, kRowLength, 8)), 0.9);
}

TEST(NeighborIndex, DistancesAreExactAndAscending) {
  const std::vector<float> rows = SmoothRows(3000, 5, 3), queries = SmoothRows(40, 5, 4);
  const Neighbors found = NeighborIndex(rows, kRowLength).Search(queries, 5);
  for (size_t i = 0; i < found.rows.size(); ++i) {
    float squared = 0;
    for (int d = 0; d < kRowLength; ++d) {
      const float step = rows[found.rows[i] * kRowLength + d] - queries[i / 5 * kRowLength + d];
      squared += step * step;
    }
    EXPECT_NEAR(found.squared[i], squared, 1e-5f);
    if (i % 5 > 0) {
      EXPECT_LE(found.squared[i - 1], found.squared[i]);
    }
  }
}

TEST(NeighborIndex, RowFindsItself) {
  const std::vector<float> rows = SmoothRows(5000, 5, 5);
  const Neighbors found =
      NeighborIndex(rows, kRowLength).Search({rows.data(), 200 * kRowLength}, 1);
  for (int i = 0; i < 200; ++i) EXPECT_EQ(found.rows[i], i);
}

TEST(NeighborIndex, RebuiltIndexGivesTheSameResult) {
  const std::vector<float> rows = SmoothRows(5000, 5, 6), queries = SmoothRows(100, 5, 7);
  const Neighbors first = NeighborIndex(rows, kRowLength).Search(queries, 8);
  NeighborIndex(SmoothRows(900, 5, 8), kRowLength);  // draws from FLANN's generator in between
  const Neighbors second = NeighborIndex(rows, kRowLength).Search(queries, 8);
  EXPECT_EQ(first.rows, second.rows);
  EXPECT_EQ(first.squared, second.squared);
}

TEST(NeighborIndex, SmallSetsAreExactAndPadded) {
  const std::vector<float> rows = SmoothRows(5, 5, 9), queries = SmoothRows(3, 5, 10);
  const Neighbors found = NeighborIndex(rows, kRowLength).Search(queries, 8);
  for (int q = 0; q < 3; ++q) {
    std::vector<int> own(found.rows.begin() + q * 8, found.rows.begin() + q * 8 + 5);
    std::sort(own.begin(), own.end());
    EXPECT_EQ(own, (std::vector{0, 1, 2, 3, 4}));
    for (int i = 5; i < 8; ++i) EXPECT_EQ(found.rows[q * 8 + i], -1);
  }
  EXPECT_TRUE(NeighborIndex({}, kRowLength).Search({}, 8).rows.empty());
}

TEST(NeighborIndex, IncompleteRowsAreRefused) {
  EXPECT_THROW(NeighborIndex(std::vector<float>(33), kRowLength), InputError);
}

}  // namespace
}  // namespace pickbed::tests
