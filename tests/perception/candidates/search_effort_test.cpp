#include "perception/candidates/search_effort.h"

#include <gtest/gtest.h>

#include "tests/sim/physics_objects.h"
#include "tests/support/analytic_clouds.h"

namespace pickbed::tests {
namespace {

TEST(LargestSilhouette, OfABoxIsSeenAlongTheSumOfItsFaceNormals) {
  // The projected area of a box along n is the sum of its face areas times |n|, so the largest is
  // the length of the vector of face areas.
  const auto box = BoxObject({0.08, 0.05, 0.02}, 0.1);
  const double largest_m2 = Eigen::Vector3d(0.08 * 0.05, 0.05 * 0.02, 0.08 * 0.02).norm();
  EXPECT_NEAR(LargestSilhouette_m2(MakeModelPoints(*box)), largest_m2, 0.04 * largest_m2);
}

TEST(LargestSilhouette, OfAConcaveObjectDoesNotCountHiddenSurface) {
  const auto bracket = BracketObject();
  const double silhouette_m2 = LargestSilhouette_m2(MakeModelPoints(*bracket));
  // From above, the plate of 80 x 40 mm hides the faces below it.
  EXPECT_GT(silhouette_m2, 0.97 * 0.08 * 0.04);
  EXPECT_LT(silhouette_m2, 0.5 * SurfaceArea(bracket->mesh_O));
}

TEST(AreaOf, AFacingSquareIsItsArea) {
  OrganizedCloud cloud;
  cloud.intrinsics = {100, 100, 400, 400, 49.5, 49.5};
  cloud.points_C.assign(100 * 100, Eigen::Vector3f(0, 0, 0.8f));
  for (int y = 20; y < 70; ++y) {
    for (int x = 20; x < 70; ++x) cloud.foreground_pixels.push_back(y * 100 + x);
  }
  const double side_m = 50 * 0.8 / 400;
  EXPECT_NEAR(AreaOf_m2(cloud, cloud.foreground_pixels), side_m * side_m, 1e-6);
}

}  // namespace
}  // namespace pickbed::tests
