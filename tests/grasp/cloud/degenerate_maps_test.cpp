// Height maps, face pairs and hand orientations of surfaces without points, of one point, and of
// points on a line or plane.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/cloud/height_map.h"
#include "grasp/cloud/opposing_faces.h"
#include "tests/grasp/cloud/cloud_scene.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kMapCell_m = 0.002;
constexpr float kNothing = -std::numeric_limits<float>::infinity();

ObservedSurface SurfaceAt(const std::vector<Vector3d>& points_B, int segment = 0) {
  ObservedSurface surface;
  for (const Vector3d& p_B : points_B) surface.points.push_back({p_B.cast<float>(), segment});
  if (segment >= 0) surface.segments.push_back({points_B.at(0), points_B.at(0).z(), 1});
  return surface;
}

std::vector<Matrix3d> DownAndTilted() {
  const Matrix3d down = FromAbove(Vector3d::Zero()).linear();
  return {down, down * Eigen::AngleAxisd(0.4, Vector3d::UnitX()).toRotationMatrix()};
}

std::vector<FacePair> PairsOf(const HeightMap& map, const ObservedSurface& surface,
                              const HandSpec& hand) {
  FaceRejections rejected;
  return FindFacePairs(map, surface.segments, hand, 0.003, 0.5, {}, rejected);
}

TEST(DegenerateMaps, WithoutPointsThereIsNoCell) {
  for (const Matrix3d& R_BG : DownAndTilted()) {
    const HeightMap map = MakeHeightMap(ObservedSurface(), R_BG, kMapCell_m, nullptr);
    EXPECT_EQ(std::pair(map.columns, map.rows), std::pair(0, 0));
    EXPECT_TRUE(map.solid_m.empty() && map.seen_m.empty() && map.segment.empty());
    EXPECT_FALSE(map.Contains(0, 0));
    EXPECT_TRUE(PairsOf(map, ObservedSurface(), SmallJaw().hand).empty());
  }
}

// Depth in another unit would need gigabytes.
TEST(DegenerateMaps, RefuseASurfaceThatIsTooWide) {
  const ObservedSurface surface = SurfaceAt({Vector3d(-30, 0, 0), Vector3d(30, 1, 0)});
  EXPECT_THAT(ErrorOf([&] { MakeHeightMap(surface, DownAndTilted()[0], kMapCell_m, nullptr); }),
              testing::HasSubstr("60.0 m x 1.0 m wide, too wide for a height map with cells of "
                                 "0.002 m; check the unit of the depth"));
}

TEST(DegenerateMaps, EqualPointsAreOneCellAtTheirHeight) {
  const Vector3d p_B(0.03, -0.02, 0.05);
  Bin point_bin;
  point_bin.inner_size_m.setZero();
  for (const Matrix3d& R_BG : DownAndTilted()) {
    const double height_m = -(R_BG.transpose() * p_B).z();
    for (const int copies : {1, 20}) {
      const ObservedSurface surface = SurfaceAt(std::vector<Vector3d>(copies, p_B));
      for (const Bin& bin : {Bin(), point_bin}) {
        const HeightMap map = MakeHeightMap(surface, R_BG, kMapCell_m, &bin);
        ASSERT_EQ(std::pair(map.columns, map.rows), std::pair(1, 1));
        EXPECT_NEAR(map.solid_m[0], height_m, 1e-6);
        EXPECT_NEAR(map.seen_m[0], height_m, 1e-6);
        EXPECT_EQ(map.segment[0], 0);
        const Vector3d center_B = map.PointIn_B(map.X_m(0), map.Y_m(0), height_m);
        EXPECT_LT((center_B - p_B).norm(), kMapCell_m);
        EXPECT_TRUE(PairsOf(map, surface, SmallJaw().hand).empty());
      }
    }
  }
}

// Points of one height have no faces.
TEST(DegenerateMaps, LinesAndPlanesHaveNoFacePairs) {
  std::vector<Vector3d> along_x, along_y, plane;
  for (int i = 0; i < 40; ++i) {
    along_x.emplace_back(0.001 * i, 0, 0.05);
    along_y.emplace_back(0, 0.001 * i, 0.05);
    for (int k = 0; k < 40; ++k) plane.emplace_back(0.001 * i, 0.001 * k, 0.05);
  }
  const Matrix3d down = DownAndTilted()[0];
  const HeightMap row = MakeHeightMap(SurfaceAt(along_x), down, kMapCell_m, nullptr);
  EXPECT_EQ(row.rows, 1);
  EXPECT_TRUE(row.columns == 20 || row.columns == 21) << row.columns;
  const HeightMap column = MakeHeightMap(SurfaceAt(along_y), down, kMapCell_m, nullptr);
  EXPECT_EQ(column.columns, 1);
  for (const auto& points : {along_x, along_y, plane}) {
    const ObservedSurface surface = SurfaceAt(points);
    const HeightMap map = MakeHeightMap(surface, down, kMapCell_m, nullptr);
    for (const float seen_m : map.seen_m) EXPECT_TRUE(seen_m == kNothing || seen_m == 0.05f);
    EXPECT_TRUE(PairsOf(map, surface, SmallJaw().hand).empty());
  }
}

TEST(DegenerateMaps, ShadowIsSolidAndHasNoFaces) {
  const ObservedSurface shadow =
      SurfaceAt({{0, 0, 0.01}, {0.02, 0, 0.05}, {0.04, 0.03, 0.01}}, kShadow);
  const HeightMap map = MakeHeightMap(shadow, DownAndTilted()[0], kMapCell_m, nullptr);
  EXPECT_TRUE(std::all_of(map.seen_m.begin(), map.seen_m.end(),
                          [](float seen_m) { return seen_m == kNothing; }));
  EXPECT_TRUE(std::all_of(map.segment.begin(), map.segment.end(),
                          [](int segment) { return segment == kBackground; }));
  EXPECT_TRUE(std::any_of(map.solid_m.begin(), map.solid_m.end(),
                          [](float solid_m) { return solid_m == 0.05f; }));
  EXPECT_TRUE(PairsOf(map, shadow, SmallJaw().hand).empty());
}

// The same map has pairs for a jaw that opens.
TEST(DegenerateMaps, AJawWithoutStrokeHasNoFacePairs) {
  CloudScene scene;
  scene.AddBox({0.07, 0.03, 0.04}, OnFloor(0.02, -0.03, 0.04, std::numbers::pi / 2));
  const ObservedSurface surface = ObserveSurface(scene.frame(), scene.camera().X_WC(),
                                                 BinPlacement{scene.bin(), Pose::Identity()});
  const HeightMap map = MakeHeightMap(surface, DownAndTilted()[0], kMapCell_m, &scene.bin());
  HandSpec hand = SmallJaw().hand;
  const std::vector<FacePair> pairs = PairsOf(map, surface, hand);
  EXPECT_FALSE(pairs.empty());
  for (const FacePair& pair : pairs) {
    EXPECT_TRUE(std::isfinite(pair.x_m + pair.y_m + pair.tips_m));
    EXPECT_TRUE(pair.width_m > 0 && pair.width_m <= hand.stroke_m) << pair.width_m;
    EXPECT_TRUE(pair.score >= 0 && pair.score <= 1) << pair.score;
  }
  hand.stroke_m = 0;
  EXPECT_TRUE(PairsOf(map, surface, hand).empty());
  hand = SmallJaw().hand;
  hand.finger_size_m.x() = hand.finger_size_m.y() = 0;
  for (const FacePair& pair : PairsOf(map, surface, hand)) {
    EXPECT_TRUE(pair.score >= 0 && pair.score <= 1) << pair.score;
  }
}

TEST(DegenerateMaps, RunningMaximumOfFewCells) {
  const std::vector<float> none, one{3}, cells{1, 4, 2, kNothing, 0, kNothing};
  for (const int half : {0, 1, 7}) {
    EXPECT_EQ(RunningMaxOfRows(none, 0, 0, half), none);
    EXPECT_EQ(RunningMaxOfColumns(none, 0, 0, half), none);
    EXPECT_EQ(RunningMaxOfRows(one, 1, 1, half), one);
    EXPECT_EQ(RunningMaxOfColumns(one, 1, 1, half), one);
  }
  EXPECT_EQ(RunningMaxOfRows(cells, 3, 2, 0), cells);
  // A window that is wider than the map.
  EXPECT_EQ(RunningMaxOfRows(cells, 3, 2, 9), (std::vector<float>{4, 4, 4, 0, 0, 0}));
  EXPECT_EQ(RunningMaxOfColumns(cells, 3, 2, 9), (std::vector<float>{1, 4, 2, 1, 4, 2}));
  const std::vector<float> nothing(4, kNothing);
  EXPECT_EQ(RunningMaxOfRows(nothing, 2, 2, 1), nothing);
  EXPECT_EQ(RunningMaxOfColumns(nothing, 2, 2, 1), nothing);
}

TEST(DegenerateMaps, WithoutATiltEveryHandPointsDown) {
  CloudAntipodalOptions options;
  options.angles = 3;
  for (const double tilt_rad : {0.0, -0.5, std::numeric_limits<double>::quiet_NaN()}) {
    const std::vector<Matrix3d> hands = HandOrientations(options, tilt_rad);
    ASSERT_EQ(hands.size(), 3u) << tilt_rad;
    for (const Matrix3d& R_BG : hands) EXPECT_EQ(R_BG.col(2), -Vector3d::UnitZ());
  }
  // Up to a hand that points sideways.
  for (const double tilt_rad : {1e-12, 0.5 * std::numbers::pi}) {
    const std::vector<Matrix3d> hands = HandOrientations(options, tilt_rad);
    ASSERT_EQ(hands.size(), static_cast<size_t>(3 + options.tilts * options.tilted_angles));
    for (const Matrix3d& R_BG : hands) {
      EXPECT_TRUE((R_BG * R_BG.transpose()).isIdentity(1e-12));
      EXPECT_NEAR(R_BG.determinant(), 1, 1e-12);
      EXPECT_LT(std::acos(std::clamp(-R_BG(2, 2), -1.0, 1.0)), tilt_rad + 1e-7);
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
