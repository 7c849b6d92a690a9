#include "grasp/cloud/height_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Orientation of a hand that points down with the closing direction along x of B.
Eigen::Matrix3d Down() { return Eigen::Vector3d(1, -1, -1).asDiagonal(); }

TEST(HeightMap, RunningMaximumEqualsTheMaximumOfEachWindow) {
  constexpr int kColumns = 23, kRows = 17;
  Rng rng(3);
  std::vector<float> values(kColumns * kRows);
  for (float& value : values) value = static_cast<float>(rng.Uniform());
  for (const int half : {0, 1, 4, 30}) {
    const auto of_rows = RunningMaxOfRows(values, kColumns, kRows, half);
    const auto of_columns = RunningMaxOfColumns(values, kColumns, kRows, half);
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        float in_row = 0, in_column = 0;
        for (int k = -half; k <= half; ++k) {
          if (x + k >= 0 && x + k < kColumns) {
            in_row = std::max(in_row, values[y * kColumns + x + k]);
          }
          if (y + k >= 0 && y + k < kRows) {
            in_column = std::max(in_column, values[(y + k) * kColumns + x]);
          }
        }
        ASSERT_EQ(of_rows[y * kColumns + x], in_row) << half;
        ASSERT_EQ(of_columns[y * kColumns + x], in_column) << half;
      }
    }
  }
}

// The map keeps the largest height against the approach, and only measured objects are seen.
TEST(HeightMap, KeepsTheHighestPointOfACell) {
  ObservedSurface surface;
  surface.segments.resize(1);
  surface.points = {{{0, 0, 0}, kBackground},
                    {{0.05f, 0.05f, 0}, kBackground},
                    {{0.0501f, 0.0501f, 0.02f}, 0},
                    {{0.0502f, 0.0502f, 0.03f}, kShadow}};
  const HeightMap map = MakeHeightMap(surface, Down(), 0.002, nullptr);
  double seen_m = -1, solid_m = -1;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.columns; ++x) {
      const int cell = map.Index(x, y);
      if (map.segment[cell] != 0) continue;
      seen_m = map.seen_m[cell];
      solid_m = map.solid_m[cell];
      const Eigen::Vector3d p_B = map.PointIn_B(map.X_m(x), map.Y_m(y), seen_m);
      EXPECT_LT((p_B - Eigen::Vector3d(0.0501, 0.0501, 0.02)).norm(), 0.002);
    }
  }
  EXPECT_NEAR(seen_m, 0.02, 1e-6);
  EXPECT_NEAR(solid_m, 0.03, 1e-6);
}

// What was not seen inside the bin is solid without limit; outside of the known bin it is free.
TEST(HeightMap, UnseenInsideOfTheBinIsSolid) {
  ObservedSurface surface;
  for (const float x : {-0.1f, 0.1f}) {
    for (const float y : {-0.1f, 0.1f}) surface.points.push_back({{x, y, 0}, kBackground});
  }
  Bin bin;
  bin.inner_size_m = {0.1, 0.1, 0.05};
  const HeightMap map = MakeHeightMap(surface, Down(), 0.01, &bin);
  const auto solid_at = [&](double x, double y) {
    const int column = static_cast<int>((x - map.corner_m.x()) / map.cell_m);
    const int row = static_cast<int>((-y - map.corner_m.y()) / map.cell_m);
    return map.solid_m[map.Index(column, row)];
  };
  EXPECT_EQ(solid_at(0, 0), INFINITY);
  EXPECT_EQ(solid_at(0.08, 0.0), -INFINITY);
  const HeightMap unknown = MakeHeightMap(surface, Down(), 0.01, nullptr);
  const int center = unknown.Index(unknown.columns / 2, unknown.rows / 2);
  EXPECT_EQ(unknown.solid_m[center], INFINITY);
}

}  // namespace
}  // namespace pickbed::tests
