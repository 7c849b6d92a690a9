#include "perception/completion/segment_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "tests/perception/completion/solid_views.h"

namespace pickbed::perception {
namespace {

using ::testing::HasSubstr;

TEST(SegmentView, OnlyNearerNeighboursAreOccluders) {
  SegmentView view = UsualSphereView();
  for (int x = 0; x < 160; ++x) {
    for (int y = 80; y < 120; ++y) {
      view.depth_m(x, y) = 0.5f;
      view.segment(x, y) = 0;
    }
  }
  const Image<uint8_t> occluders = MarkOccluders(view);
  const Eigen::Vector2d center = Project(TestCamera(), kSphereCenter_C);
  const int u = static_cast<int>(center.x());
  EXPECT_EQ(occluders(u, 82), 1);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 160; ++x) EXPECT_EQ(occluders(x, y), 0);
  }
}

TEST(SegmentView, RefusesImagesOfAnotherSize) {
  SegmentView view = UsualSphereView();
  view.segment = Image<uint8_t>(10, 10, 1);
  try {
    CheckSegmentView(view);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("segment has 10 x 10 px, but the camera has 160 x 120"));
  }
}

TEST(SegmentView, RefusesFewPixels) {
  SegmentView view = UsualSphereView();
  view.segment = Image<uint8_t>(160, 120, 0);
  for (int x = 0; x < kMinSegmentPixels - 1; ++x) view.segment(x, 0) = 1;
  EXPECT_THROW(CheckSegmentView(view), InputError);
  view.segment(kMinSegmentPixels - 1, 0) = 1;
  EXPECT_NO_THROW(CheckSegmentView(view));
}

}  // namespace
}  // namespace pickbed::perception
