#include "scenes/geometry/sphere_directions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace pickbed::tests {
namespace {

using scenes::SphereDirections;

TEST(SphereDirections, UnitVectorsAreSpreadEvenly) {
  constexpr int kCount = 200;
  const std::vector<Eigen::Vector3d> directions = SphereDirections(kCount);
  ASSERT_EQ(directions.size(), kCount);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < kCount; ++i) {
    EXPECT_NEAR(directions[i].norm(), 1, 1e-12);
    sum += directions[i];
    double nearest_cos = -1;
    for (int j = 0; j < kCount; ++j) {
      if (j != i) nearest_cos = std::max(nearest_cos, directions[i].dot(directions[j]));
    }
    // The best possible spacing of 200 directions is about 15 degrees.
    EXPECT_LT(nearest_cos, std::cos(0.17)) << i;
    EXPECT_GT(nearest_cos, std::cos(0.30)) << i;
  }
  EXPECT_LT(sum.norm() / kCount, 0.01);
}

}  // namespace
}  // namespace pickbed::tests
