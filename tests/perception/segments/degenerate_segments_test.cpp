// Segments of degenerate depth images and of degenerate graphs.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/segments/edge_contraction.h"
#include "perception/segments/object_segments.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

void ExpectSound(const ObjectSegments& found, const std::string& name) {
  std::vector<int> pixels(found.segments.size() + 1, 0);
  for (int y = 0; y < found.labels.height(); ++y) {
    for (int x = 0; x < found.labels.width(); ++x) {
      ASSERT_LE(found.labels(x, y), found.segments.size()) << name;
      ++pixels[found.labels(x, y)];
    }
  }
  for (size_t i = 0; i < found.segments.size(); ++i) {
    EXPECT_EQ(pixels[i + 1], found.segments[i].pixels) << name;
    EXPECT_TRUE(found.segments[i].center_C.allFinite()) << name;
    EXPECT_GT(found.segments[i].center_C.z(), 0) << name;
  }
}

TEST(DegenerateSegments, EveryMethodGivesSoundSegments) {
  for (const DepthCase& test : DepthCases()) {
    RgbdFrame frame = FrameOf(test);
    frame.color = Image<Rgb8>(frame.depth_m.width(), frame.depth_m.height());
    for (const SegmenterRow& row : SegmenterTable()) {
      const std::string name = std::string(test.name) + ", " + row.name;
      ExpectSound(SegmentFrame(frame, std::nullopt, row.options()), name);
      const KnownBackground bin{Bin(), Translation({0, 0, 0.9})};
      ExpectSound(SegmentFrame(frame, bin, row.options()), name);
    }
  }
}

TEST(DegenerateSegments, ImagesWithoutAReadingHaveNone) {
  for (const DepthCase& test : DepthCases()) {
    const std::string name = test.name;
    if (name != "no reading" && name != "one reading" && test.not_finite != kDegeneratePixels) {
      continue;
    }
    EXPECT_TRUE(SegmentFrame(FrameOf(test), std::nullopt).segments.empty()) << name;
  }
}

TEST(DegeneratePatches, CentersAndNormalsAreFinite) {
  for (const DepthCase& test : DepthCases()) {
    const OrganizedCloud cloud = BuildCloud(FrameOf(test), std::nullopt, {.min_plane_share = 1});
    const SurfacePatches found = FindPatches(cloud);
    const int count = static_cast<int>(found.patches.size());
    for (const SurfacePatch& patch : found.patches) {
      EXPECT_TRUE(patch.center_C.allFinite() && patch.color.allFinite()) << test.name;
      const float norm = patch.normal_C.norm();
      EXPECT_TRUE(norm == 0 || std::abs(norm - 1) < 1e-3f) << test.name << " " << norm;
      EXPECT_GT(patch.pixels, 0) << test.name;
    }
    for (const PatchBorder& border : found.borders) {
      EXPECT_TRUE(0 <= border.a && border.a < border.b && border.b < count) << test.name;
    }
  }
}

TEST(DegenerateGraphs, NodesWithoutAttractionStayApart) {
  EXPECT_TRUE(ContractEdges(0, {}).empty());
  EXPECT_EQ(ContractEdges(1, {}), std::vector<int>{0});
  const std::vector<int> apart{0, 1, 2}, joined{0, 0, 1};
  EXPECT_EQ(ContractEdges(3, {}), apart);
  EXPECT_EQ(ContractEdges(3, {{0, 1, 0}, {1, 2, 0}}), apart);
  EXPECT_EQ(ContractEdges(3, {{0, 1, -1e300}, {1, 2, -1e300}}), apart);
  EXPECT_EQ(ContractEdges(3, {{0, 1, 1e300}, {1, 2, -1e300}}), joined);
  // Parallel edges whose weights cancel.
  EXPECT_EQ(ContractEdges(3, {{0, 1, 1}, {1, 0, -1}}), apart);
  EXPECT_THROW(ContractEdges(3, {{0, 0, 1}}), std::logic_error);
  EXPECT_THROW(ContractEdges(3, {{0, 3, 1}}), std::logic_error);
  EXPECT_THROW(ContractEdges(0, {{0, 1, 1}}), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
