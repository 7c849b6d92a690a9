// Collision checks of hands with obstacles of no points, one point, equal points, points on a line
// and points that are far away, and with boxes that have no volume.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "grasp/grippers/suction_cup.h"
#include "grasp/plan/clearance.h"
#include "grasp/plan/hidden_space.h"
#include "grasp/plan/lift_aside.h"
#include "grasp/plan/lift_clearance.h"
#include "grasp/plan/stacking.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

AxisAlignedBox DotAt(const Vector3d& center) { return {center, Vector3d::Zero()}; }

Matrix3Xd ColumnsOf(const std::vector<Vector3d>& points) {
  Matrix3Xd columns(3, static_cast<Eigen::Index>(points.size()));
  for (size_t i = 0; i < points.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return columns;
}

ObstacleField FieldOf(const std::vector<Vector3d>& points_W) {
  return {points_W, std::vector<int>(points_W.size(), 0), 0.01};
}

TEST(DegenerateSweeps, AClosedHandHasNoRegionBetweenItsFingers) {
  const ParallelJaw jaw = SmallJaw();
  const std::vector<AxisAlignedBox> boxes = jaw.Boxes(0), sweep = HandSweep(jaw, 0);
  ASSERT_EQ(boxes.size(), 3u);
  ASSERT_EQ(sweep.size(), 3u);
  for (int finger = 0; finger < 2; ++finger) {
    EXPECT_NEAR(std::abs(boxes[finger].center.x()), boxes[finger].half_size.x(), 1e-12)
        << "the pads touch in the middle";
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE((sweep[i].half_size.array() > 0).all());
    EXPECT_NEAR(sweep[i].half_size.z() - boxes[i].half_size.z(), 0.5 * jaw.approach_m, 1e-12);
    EXPECT_NEAR(sweep[i].center.z() + sweep[i].half_size.z(),
                boxes[i].center.z() + boxes[i].half_size.z(), 1e-12)
        << "it ends where the hand ends";
  }
  EXPECT_EQ(jaw.RegionBetween(0)->half_size.x(), 0);
  EXPECT_FALSE(HandMeetsBin(jaw, 0, FromAbove({0, 0, 0}), {}, 0.002)) << "no bin";
}

TEST(DegenerateSweeps, ADotMeetsTheWallThatItIsIn) {
  const Bin bin;
  const std::vector<AxisAlignedBox> walls = BinBoxes(bin);
  const auto meets = [&](const Vector3d& p_W, double clearance_m) {
    const AxisAlignedBox dot = DotAt(Vector3d::Zero());
    return FindBinContact({&dot, 1}, Translation(p_W), walls, clearance_m).has_value();
  };
  const double wall_x_m = 0.5 * bin.inner_size_m.x();
  EXPECT_TRUE(meets({wall_x_m + 0.5 * bin.wall_m, 0, 0.05}, 0));
  EXPECT_FALSE(meets({wall_x_m - 0.001, 0, 0.05}, 0));
  EXPECT_TRUE(meets({wall_x_m - 0.001, 0, 0.05}, 0.002));
  EXPECT_TRUE(meets({0, 0, -0.5 * bin.wall_m}, 0)) << "the floor";
  EXPECT_FALSE(FindBinContact({}, Pose::Identity(), walls, 1)) << "no hand";
  const AxisAlignedBox dot = DotAt(Vector3d::Zero());
  EXPECT_FALSE(FindBinContact({&dot, 1}, Pose::Identity(), {}, 1)) << "no bin";
}

TEST(DegenerateSweeps, NothingIsInsideOfABoxWithoutVolume) {
  const Matrix3Xd origin = Matrix3Xd::Zero(3, 1), none(3, 0);
  const AxisAlignedBox dot = DotAt(Vector3d::Zero()), flat{Vector3d::Zero(), {1, 1, 0}},
                       cube{Vector3d::Zero(), {1, 1, 1}};
  EXPECT_FALSE(AnyInside(origin, {&dot, 1}));
  EXPECT_FALSE(AnyInside(origin, {&flat, 1}));
  EXPECT_TRUE(AnyInside(origin, {&cube, 1}));
  EXPECT_FALSE(AnyInside(none, {&cube, 1}));
  EXPECT_FALSE(AnyInside(origin, {}));
  EXPECT_FALSE(AnyInside(Vector3d(1, 0, 0), {&cube, 1})) << "on a face";
}

TEST(DegenerateBands, ContainNothingWithoutPointsAndABallAroundEqualPoints) {
  constexpr double kWide_m = 0.006;
  const SurfaceBand none(Matrix3Xd(3, 0), kWide_m);
  const Vector3d p(0.1, -0.2, 0.3);
  const SurfaceBand one(p, kWide_m), equal(p.replicate(1, 50), kWide_m);
  EXPECT_FALSE(none.Contains(Vector3d::Zero()));
  EXPECT_TRUE(one.Contains(p));
  for (double x = -0.012; x <= 0.012; x += 0.0015) {
    for (double z = -0.012; z <= 0.012; z += 0.0015) {
      const Vector3d way(x, 0.001, z);
      EXPECT_FALSE(none.Contains(p + way));
      EXPECT_EQ(one.Contains(p + way), equal.Contains(p + way));
      // The resolution is half of the band.
      EXPECT_TRUE(one.Contains(p + way) || way.norm() >= 0.5 * kWide_m) << way.transpose();
      EXPECT_FALSE(one.Contains(p + way) && way.norm() > 1.5 * kWide_m) << way.transpose();
    }
  }
}

TEST(DegenerateThinnedClouds, KeepOnePointOfEqualOnesAndNoneThatIsNotFinite) {
  const Bin bin;
  const auto thinned = [&](const std::vector<Vector3d>& cloud_W) {
    return ThinnedCloud(cloud_W, bin, 0.003, 0.004, 0.2);
  };
  const Vector3d p(0.05, 0.02, 0.03);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(thinned({}).empty());
  EXPECT_EQ(thinned(std::vector<Vector3d>(100, p)), std::vector<Vector3d>{p});
  EXPECT_TRUE(
      thinned({{kNotANumber, 0, 0.03}, {0, kNotANumber, 0.03}, {0, 0, kNotANumber}}).empty());
  EXPECT_TRUE(thinned({{kInfinity, 0, 0.03}, {0, -kInfinity, 0.03}, {0, 0, 1e300}}).empty());
  EXPECT_EQ(thinned({{0, 0, kNotANumber}, p, {0, 0, -kInfinity}}), std::vector<Vector3d>{p});
}

// Distances by the definition.
double NearestByScan(const std::vector<Vector3d>& points_W, const AxisAlignedBox& box_G,
                     const Pose& X_WG, double limit_m) {
  double nearest_m = limit_m;
  for (const Vector3d& p_W : points_W) {
    const Vector3d p_G = X_WG.inverse() * p_W;
    nearest_m = std::min(nearest_m, ((p_G - box_G.center).cwiseAbs() - box_G.half_size).maxCoeff());
  }
  return nearest_m;
}

TEST(DegenerateFields, AnswersEqualAFullScan) {
  const Vector3d p(0.013, -0.021, 0.03);
  std::vector<Vector3d> line, upright, far_apart{{-2e6, 3e6, 0}, p, {4e6, -1e6, 5e5}};
  for (int i = 0; i < 30; ++i) {
    line.emplace_back(0.002 * i, 0.002 * i, 0.03);
    upright.emplace_back(p + 0.001 * i * Vector3d::UnitZ());
  }
  const std::vector<std::vector<Vector3d>> clouds{{},   {p},     std::vector<Vector3d>(40, p),
                                                  line, upright, far_apart};
  const std::vector<AxisAlignedBox> boxes{DotAt({0, 0, -0.01}),
                                          {{0.01, 0, -0.02}, {0.01, 0.02, 0}},
                                          {{0, 0, -0.04}, {0, 0, 0.04}},
                                          {{0, 0, -0.03}, {0.02, 0.02, 0.03}}};
  constexpr double kLimit_m = 0.02;
  for (size_t k = 0; k < clouds.size(); ++k) {
    const ObstacleField field = FieldOf(clouds[k]);
    ASSERT_EQ(field.points_W().size(), clouds[k].size());
    const std::vector<uint8_t> none_ignored{0}, all_ignored{1};
    for (const Pose& X_WG : {FromAbove({0.01, -0.02, 0.02}), FromAbove({0.03, 0.03, 0.02}, 0.7),
                             Translation(p), FromAbove({0.3, 0.3, 0.1})}) {
      const auto answer = field.Query(X_WG, boxes, boxes.back(), none_ignored, kLimit_m);
      std::optional<int> first_met;
      for (size_t i = 0; i < boxes.size(); ++i) {
        const double expected_m = NearestByScan(clouds[k], boxes[i], X_WG, kLimit_m);
        EXPECT_NEAR(answer.distance_m[i], expected_m, 1e-9) << k << " " << i;
        if (!first_met && expected_m < 0.004) first_met = static_cast<int>(i);
      }
      EXPECT_EQ(field.FirstMet(X_WG, boxes, none_ignored, 0.004), first_met) << k;
      EXPECT_FALSE(field.FirstMet(X_WG, boxes, all_ignored, 0.004)) << k;
      EXPECT_EQ(field.Query(X_WG, {}, std::nullopt, none_ignored, kLimit_m).between, 0);
    }
    for (const double wrong : {std::numeric_limits<double>::infinity(), kNotANumber}) {
      const Pose nowhere = Translation({0, wrong, 0});
      EXPECT_FALSE(field.FirstMet(nowhere, boxes, none_ignored, 0.004)) << wrong;
    }
    EXPECT_FALSE(field.FirstMet(Translation({1e30, -1e30, 0}), boxes, none_ignored, 0.004));
    EXPECT_EQ(field.CoveredShare(Matrix3Xd(3, 0), none_ignored, 0.004), 0) << "no surface";
  }
  const Matrix3Xd below = p - Vector3d(0, 0, 0.01);
  EXPECT_EQ(FieldOf({}).CoveredShare(below, {0}, 0.004), 0);
  EXPECT_EQ(FieldOf({p, p}).CoveredShare(below, {0}, 0.004), 1);
  EXPECT_EQ(FieldOf({p, p}).CoveredShare(below, {0}, 0.02), 0);
}

TEST(DegenerateHiddenSpace, VolumesAreFiniteAndNoLargerThanTheBoxes) {
  const Pose X_CB = FromAbove({0, 0, 0.8}).inverse();
  const AxisAlignedBox cube{Vector3d::Zero(), Vector3d::Constant(0.01)};
  const std::vector<AxisAlignedBox> flat{DotAt(Vector3d::Zero()),
                                         {Vector3d::Zero(), {0.01, 0.01, 0}},
                                         {Vector3d::Zero(), {0, 0, 0.05}}};
  for (const DepthCase& test : DepthCases()) {
    const RgbdFrame frame = FrameOf(test);
    const HiddenSpace hidden(frame.depth_m, frame.intrinsics, X_CB, 0.005);
    for (const Vector3d& p_B : {Vector3d(0, 0, 0), Vector3d(0, 0, 0.8), Vector3d(0, 0, 2)}) {
      const Pose X_BG = Translation(p_B);
      const double volume_m3 = hidden.HiddenVolume_m3({&cube, 1}, X_BG, 0.004);
      EXPECT_TRUE(volume_m3 >= 0 && volume_m3 <= 8e-6 * (1 + 1e-9)) << test.name;
      EXPECT_EQ(hidden.HiddenVolume_m3(flat, X_BG, 0.004), 0) << test.name;
      EXPECT_EQ(hidden.HiddenVolume_m3({}, X_BG, 0.004), 0) << test.name;
      EXPECT_EQ(hidden.MeanDepth_m({}, X_BG, 0.004), 0) << test.name;
      EXPECT_EQ(hidden.MeanDepth_m({&cube, 1}, X_BG, 0.004), 0) << "a palm without fingers";
      EXPECT_EQ(hidden.MeanDepth_m(flat, X_BG, 0.004), 0) << "fingers without a cross-section";
    }
    const bool no_reading = std::string(test.name) == "no reading";
    if (no_reading || test.not_finite == kDegeneratePixels) {
      EXPECT_EQ(hidden.HiddenVolume_m3({&cube, 1}, Pose::Identity(), 0.004), 0) << test.name;
    }
  }
}

TEST(DegenerateLifts, WithoutADirectionOrRoomThereIsNoShift) {
  const Vector2d p(0.02, 0.03);
  EXPECT_TRUE(AwayFrom(p, p, 0.05).isZero());
  EXPECT_TRUE(AwayFrom({0, 0}, p, 0).isZero());
  const Bin bin;
  const Pose X_BG = FromAbove({0, 0, 0.02});
  const Matrix3Xd none(3, 0), center = Vector3d(0, 0, 0.02);
  EXPECT_TRUE(ShiftInBin(Vector2d::Zero(), bin, center, {}, X_BG).isZero());
  const Vector2d far_m(9, -9), half_m = 0.5 * bin.inner_size_m.head<2>();
  const Vector2d room_m(half_m.x() - 0.01, 0.01 - half_m.y());
  const AxisAlignedBox dot = DotAt(Vector3d::Zero());
  EXPECT_TRUE(ShiftInBin(far_m, bin, none, {}, X_BG).isApprox(room_m));
  EXPECT_TRUE(ShiftInBin(far_m, bin, center, {}, X_BG).isApprox(room_m));
  EXPECT_TRUE(ShiftInBin(far_m, bin, center.replicate(1, 9), {&dot, 1}, X_BG).isApprox(room_m));
  Bin narrow;
  narrow.inner_size_m = {0.015, 0.3, 0.1};
  EXPECT_EQ(ShiftInBin({0.05, 0}, narrow, center, {}, X_BG), Vector2d::Zero());
}

TEST(DegenerateLifts, OnlyVerticesMeetAWall) {
  const Bin bin;
  ObjectModel object;
  const auto meets = [&](const Vector3d& p_B) {
    return LiftMeetsWall(bin, object, Translation(p_B), 0.001);
  };
  const double wall_x_m = 0.5 * bin.inner_size_m.x();
  EXPECT_FALSE(meets({wall_x_m, 0, 0.02})) << "no vertices";
  for (const size_t copies : {1, 5}) {
    object.mesh_O.vertices.assign(copies, Vector3d::Zero());
    EXPECT_FALSE(meets({0, 0, 0.02}));
    EXPECT_TRUE(meets({wall_x_m, 0, 0.02}));
    EXPECT_FALSE(meets({wall_x_m, 0, bin.inner_size_m.z()})) << "above the rim";
  }
  Bin point_bin;
  point_bin.inner_size_m = {0, 0, 0.1};
  EXPECT_TRUE(LiftMeetsWall(point_bin, object, Translation({0, 0, 0.02}), 0.001));
}

TEST(DegenerateStacks, PointsAndLinesAreAboveEachOtherByTheirHeight) {
  InstanceStack stack(0.005);
  std::vector<Vector3d> line;
  for (int i = 0; i < 8; ++i) line.emplace_back(0.0025 + 0.005 * i, 0.0025, 0.02);
  stack.Add(Matrix3Xd(3, 0));                                    // 0: no points
  stack.Add(ColumnsOf(line));                                    // 1
  stack.Add(Vector3d(0.0025, 0.0025, 0.03));                     // 2: on the begin of the line
  stack.Add(Vector3d(0.0025, 0.0025, 0.03).replicate(1, 9));     // 3: the same, nine times
  stack.Add(ColumnsOf(line).colwise() + Vector3d(0, 0, 0.005));  // 4: a line on the line
  EXPECT_TRUE(stack.Above(0).empty());
  EXPECT_EQ(stack.Above(1), (std::vector<int>{2, 3, 4}));
  EXPECT_TRUE(stack.Above(2).empty()) << "equal heights";
  EXPECT_EQ(stack.Above(4), (std::vector<int>{2, 3}));
  const std::vector<bool> all(5, true), none(5, false), one{false, false, true, false, false},
      only_line{false, false, false, false, true};
  EXPECT_FALSE(stack.CenterOfCover(0, all));
  EXPECT_FALSE(stack.CenterOfCover(1, none));
  EXPECT_FALSE(stack.CenterOfCover(1, one)) << "a point covers one cell";
  const auto center = stack.CenterOfCover(1, only_line);
  ASSERT_TRUE(center);
  EXPECT_NEAR((*center - Vector2d(0.02, 0.0025)).norm(), 0, 1e-12) << "the middle of the line";
}

}  // namespace
}  // namespace pickbed::tests
