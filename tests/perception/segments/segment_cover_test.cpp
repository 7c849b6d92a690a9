#include "perception/segments/segment_cover.h"

#include <gtest/gtest.h>

#include "tests/support/error_of.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr float kFloor_m = 1.0f, kLow_m = 0.97f, kHigh_m = 0.94f;

// An image of rectangles on a floor. The last one that is drawn hides the others.
class Rectangles {
 public:
  Rectangles() : depth_m_(40, 30, kFloor_m) { segments_.labels = Image<uint16_t>(40, 30, 0); }
  // Pixels from (left, top) on, without (right, bottom).
  void Add(int left, int top, int right, int bottom, float depth_m) {
    segments_.segments.emplace_back();
    const auto label = static_cast<uint16_t>(segments_.segments.size());
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        depth_m_(x, y) = depth_m;
        segments_.labels(x, y) = label;
      }
    }
  }
  // Takes the readings of a column.
  void Blind(int x) {
    for (int y = 0; y < depth_m_.height(); ++y) {
      depth_m_(x, y) = 0;
      segments_.labels(x, y) = 0;
    }
  }
  std::vector<double> Shares(const CoverOptions& options = {}) const {
    return CoveredShares(depth_m_, segments_, options);
  }

 private:
  Image<float> depth_m_;
  ObjectSegments segments_;
};

TEST(SegmentCover, AnObjectAloneIsNotCovered) {
  Rectangles image;
  image.Add(10, 10, 20, 20, kLow_m);
  EXPECT_EQ(image.Shares(), std::vector<double>{0});
}

// The right one of the four sides of a square borders a higher object: a quarter of its pairs, up
// to the diagonals of the corners.
TEST(SegmentCover, OneOfFourSidesIsAQuarter) {
  Rectangles image;
  image.Add(10, 10, 20, 20, kLow_m);
  image.Add(20, 5, 30, 25, kHigh_m);
  const std::vector<double> shares = image.Shares();
  EXPECT_NEAR(shares[0], 0.25, 0.02);
  EXPECT_EQ(shares[1], 0) << "the higher object is free";
}

TEST(SegmentCover, AnObjectUnderABarIsCoveredOnBothSidesOfIt) {
  Rectangles image;
  image.Add(5, 5, 35, 25, kLow_m);
  const double free = image.Shares()[0];
  image.Add(18, 0, 22, 30, kHigh_m);
  EXPECT_EQ(free, 0);
  // Two ends of 20 px of two pieces of 13 x 20 px.
  EXPECT_NEAR(image.Shares()[0], 2 * 20 / (4 * 13 + 4 * 20.0), 0.02);
}

TEST(SegmentCover, ASmallStepDoesNotCover) {
  Rectangles image;
  image.Add(10, 10, 20, 20, kLow_m);
  image.Add(20, 5, 30, 25, kLow_m - 0.002f);
  EXPECT_EQ(image.Shares()[0], 0);
  EXPECT_GT(image.Shares({.step_m = 0.001})[0], 0.2);
}

// Sensors have no readings at edges.
TEST(SegmentCover, TheNeighbourIsFoundBeyondAGap) {
  Rectangles image;
  image.Add(10, 10, 20, 20, kLow_m);
  image.Add(20, 5, 30, 25, kHigh_m);
  image.Blind(20);
  image.Blind(21);
  EXPECT_NEAR(image.Shares()[0], 0.25, 0.02);
  EXPECT_EQ(image.Shares({.search_px = 2})[0], 0) << "no reading within 2 px";
}

// A gap inside of a segment is no contour.
TEST(SegmentCover, AGapOfASegmentIsNoContour) {
  Rectangles image;
  image.Add(10, 10, 20, 20, kLow_m);
  image.Add(20, 5, 30, 25, kHigh_m);
  const double without_gap = image.Shares()[0];
  image.Blind(14);
  EXPECT_NEAR(image.Shares()[0], without_gap, 0.02);
}

TEST(SegmentCover, ImagesWithoutSegmentsAndBadOptions) {
  EXPECT_TRUE(Rectangles().Shares().empty());
  EXPECT_NE(ErrorOf([] { return Rectangles().Shares({.search_px = 0}); }).find("search_px"),
            std::string::npos);
}

}  // namespace
}  // namespace pickbed::tests
