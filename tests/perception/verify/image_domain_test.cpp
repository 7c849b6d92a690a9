#include "perception/verify/image_domain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(LogitPenalty, IsZeroInsideAndNeverFalls) {
  EXPECT_EQ(LogitPenalty({0.2, 0.002, 0.5}, 60), 0);
  double last = 0;
  for (double holes = 0; holes <= 1; holes += 0.1) {
    const double penalty = LogitPenalty({holes, 0.002, 0.5}, 60);
    EXPECT_GE(penalty, last);
    last = penalty;
  }
  EXPECT_GT(last, 0);
  EXPECT_GT(LogitPenalty({0, 0.02, 0}, 60), LogitPenalty({0, 0.01, 0}, 60));
  EXPECT_GT(LogitPenalty({0, 0, 1.5}, 60), 0);
  EXPECT_GT(LogitPenalty({}, 5), LogitPenalty({}, 10));
}

// Holes count only between readings: the empty image beside an object is no failure.
TEST(DomainOf, EmptySurroundingsAreNoHoles) {
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BoxMesh({0.1, 0.1, 0.02}, Eigen::Vector3d::Zero()), Translation({0, 0, 0.5}));
  RgbdFrame frame = scene.frame();
  EXPECT_LT(DomainOf(BuildCloud(frame, std::nullopt, kKeepAll)).hole_share, 0.02);
  int seen = 0;
  for (float& z : frame.depth_m.pixels()) {
    if (z > 0 && ++seen % 5 > 1) z = 0;
  }
  const ImageDomain domain = DomainOf(BuildCloud(frame, std::nullopt, kKeepAll));
  EXPECT_GT(domain.hole_share, kMaxHoleShare);
  ASSERT_EQ(DomainWarnings(domain).size(), 1u);
  EXPECT_THAT(DomainWarnings(domain).front(), HasSubstr("% of the depth is missing"));
}

}  // namespace
}  // namespace pickbed::tests
