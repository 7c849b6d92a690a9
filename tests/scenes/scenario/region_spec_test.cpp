#include "scenes/scenario/region_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

TEST(ParseRegion, TakesBoxesMasksAndTheAutomaticRegion) {
  const RegionSpec box = ParseRegion("camera:0.1,-0.2,1,-0.1,0.2,0.5");
  EXPECT_EQ(box.frame, "camera");
  EXPECT_EQ(box.min_m, Eigen::Vector3d(-0.1, -0.2, 0.5)) << "the corners may come in any order";
  EXPECT_EQ(box.max_m, Eigen::Vector3d(0.1, 0.2, 1));
  EXPECT_TRUE(ParseRegion("auto").automatic);
  EXPECT_EQ(ParseRegion("world.png").mask, "world.png");
  EXPECT_TRUE(RegionSpec().empty());
  EXPECT_FALSE(box.empty());
}

TEST(ParseRegion, RefusesOtherTextsInOneLine) {
  EXPECT_THAT(ErrorOf([] { ParseRegion("world:1,2,3"); }), HasSubstr("world:X,Y,Z,X,Y,Z"));
  EXPECT_THAT(ErrorOf([] { ParseRegion("camera:1,2,x,4,5,6"); }), HasSubstr("two corners"));
  EXPECT_THAT(ErrorOf([] { ParseRegion("camera:0,0,1,1,1,1"); }), HasSubstr("no volume"));
  EXPECT_THAT(ErrorOf([] { ParseRegion(""); }), HasSubstr("auto"));
}

TEST(RegionSpec, OnlyOneKindIsAllowed) {
  RegionSpec region = ParseRegion("world:0,0,0,1,1,1");
  EXPECT_EQ(ErrorOf([&] { region.Validate("roi"); }), "no error");
  region.automatic = true;
  EXPECT_THAT(ErrorOf([&] { region.Validate("a.yaml:3: roi"); }),
              HasSubstr("a.yaml:3: roi: give only one"));
  region = RegionSpec();
  region.max_m = {1, 0, 1};
  EXPECT_THAT(ErrorOf([&] { region.Validate("roi"); }), HasSubstr("no volume"));
}

}  // namespace
}  // namespace pickbed::tests
