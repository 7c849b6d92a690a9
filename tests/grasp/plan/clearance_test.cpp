#include "grasp/plan/clearance.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

// Reference: the boxes intersect if a point of a fine grid in one is inside the other.
bool IntersectBySampling(const AxisAlignedBox& box_W, const AxisAlignedBox& box_G,
                         const Pose& X_WG) {
  constexpr int kSteps = 40;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k <= kSteps; ++k) {
        const Vector3d unit = Vector3d(i, j, k) * (2.0 / kSteps) - Vector3d::Ones();
        const Vector3d p = X_WG * (box_G.center + unit.cwiseProduct(box_G.half_size));
        if (((p - box_W.center).cwiseAbs().array() <= box_W.half_size.array()).all()) return true;
      }
    }
  }
  return false;
}

TEST(Clearance, BoxTestAgreesWithSampling) {
  Rng rng(3);
  const AxisAlignedBox fixed{{0.1, 0, -0.1}, {0.2, 0.1, 0.15}};
  int intersecting = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const AxisAlignedBox moving{{0.02, 0, 0}, {0.05, 0.12, 0.08}};
    const Pose X_WG = MakePose(rng.Rotation().toRotationMatrix(), 0.3 * rng.UnitVector());
    const bool intersects = IntersectBySampling(fixed, moving, X_WG);
    const auto found = FindBinContact({&moving, 1}, X_WG, {&fixed, 1}, 0);
    if (intersects) {
      EXPECT_TRUE(found) << trial;
    }
    // The grid can miss a corner that is just inside, so the other direction allows for its step.
    AxisAlignedBox grown = moving;
    grown.half_size *= 1.1;
    if (found) {
      EXPECT_TRUE(IntersectBySampling(fixed, grown, X_WG)) << trial;
    }
    intersecting += intersects;
  }
  EXPECT_GT(intersecting, 30);
  EXPECT_LT(intersecting, 170);
}

TEST(ObstacleField, EachPointNeedsAGroup) {
  EXPECT_THROW(ObstacleField({Vector3d::Zero()}, {-1}, 0.01), std::logic_error);
  EXPECT_THROW(ObstacleField({Vector3d::Zero()}, {}, 0.01), std::logic_error);
  EXPECT_NO_THROW(ObstacleField({Vector3d::Zero()}, {0}, 0.01));
}

TEST(Clearance, FingertipsKeepTheirClearanceFromTheFloor) {
  const Bin bin;
  const auto boxes = BinBoxes(bin);
  const auto sweep = HandSweep(SmallJaw(), 0.05);
  EXPECT_FALSE(FindBinContact(sweep, FromAbove({0, 0, 0.0031}), boxes, 0.003));
  const auto contact = FindBinContact(sweep, FromAbove({0, 0, 0.0029}), boxes, 0.003);
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->bin_box, 0);
  EXPECT_LT(contact->hand_box, 2);
}

// A jaw may reach over the rim, but not close on the wall between its fingers.
TEST(Clearance, FingersOnBothSidesOfAWallMeetTheBin) {
  Bin bin;
  bin.inner_size_m = {0.4, 0.3, 0.12};
  const auto boxes = BinBoxes(bin);
  const double wall_m = 0.5 * bin.inner_size_m.x() + 0.5 * bin.wall_m;
  const auto meets = [&](const Pose& X_WG) {
    return HandMeetsBin(SmallJaw(), 0.07, X_WG, boxes, 0.002);
  };
  const Pose across = FromAbove({wall_m, 0, 0.09});
  EXPECT_FALSE(FindBinContact(HandSweep(SmallJaw(), 0.07), across, boxes, 0.002));
  EXPECT_TRUE(meets(across));
  EXPECT_TRUE(meets(FromAbove({wall_m, 0, bin.inner_size_m.z() - 0.001})));
  EXPECT_FALSE(meets(FromAbove({wall_m, 0, bin.inner_size_m.z() + 0.004})));
  EXPECT_FALSE(meets(FromAbove({0, 0, 0.09})));
}

TEST(Clearance, SweepExtendsBackByTheApproach) {
  const ParallelJaw gripper = SmallJaw();
  const HandSpec& hand = gripper.hand;
  const auto sweep = HandSweep(gripper, 0.05);
  for (int finger = 0; finger < 2; ++finger) {
    const AxisAlignedBox& box = sweep[finger];
    EXPECT_NEAR(box.center.z() + box.half_size.z(), 0, 1e-12);
    EXPECT_NEAR(box.center.z() - box.half_size.z(), -hand.finger_size_m.z() - gripper.approach_m,
                1e-12);
  }
  EXPECT_NEAR(sweep[1].center.x() - sweep[1].half_size.x(), 0.025, 1e-12);
}

TEST(Clearance, SurfaceBandApproximatesTheDistance) {
  Eigen::Matrix3Xd point(3, 1);
  point.col(0) = Vector3d(0.1, 0.2, 0.3);
  const SurfaceBand band(point, 0.006);
  Rng rng(4);
  for (int i = 0; i < 2000; ++i) {
    const double distance = rng.Uniform(0, 0.012);
    const bool inside = band.Contains(point.col(0) + distance * rng.UnitVector());
    if (distance < 0.003) {
      EXPECT_TRUE(inside);
    }
    if (distance > 0.009) {
      EXPECT_FALSE(inside);
    }
  }
  EXPECT_FALSE(band.Contains(Vector3d(5, 5, 5)));
}

TEST(Clearance, ThinnedCloudHasOnePointPerVoxelInsideTheBin) {
  const Bin bin;
  const double wall = 0.5 * bin.inner_size_m.x();
  const std::vector<Vector3d> cloud = {{0, 0, 0.05},        {0.0001, 0, 0.05}, {0.02, 0, 0.05},
                                       {0, 0, 0.001},       {wall, 0, 0.05},   {2, 0, 0.05},
                                       {0, 0, std::nan("")}};
  const auto thinned = ThinnedCloud(cloud, bin, 0.003, 0.004, 0.2);
  ASSERT_EQ(thinned.size(), 2u);
  EXPECT_EQ(thinned[0], cloud[0]);
  EXPECT_EQ(thinned[1], cloud[2]);
}

TEST(Clearance, FieldEqualsAFullScan) {
  Rng rng(7);
  std::vector<Vector3d> points;
  for (int i = 0; i < 3000; ++i) {
    points.emplace_back(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.15, 0.15), rng.Uniform(0, 0.1));
  }
  std::vector<int> groups(points.size());
  for (size_t i = 0; i < groups.size(); ++i) groups[i] = static_cast<int>(i / 2);
  const ObstacleField field(points, groups, 0.01);
  ASSERT_EQ(field.points_W().size(), points.size());
  std::vector<uint8_t> ignored(points.size());
  for (size_t i = 0; i < ignored.size(); i += 3) ignored[i] = 1;
  ParallelJaw gripper = SmallJaw();
  gripper.approach_m = 0.1;
  const auto sweep = HandSweep(gripper, 0.04);
  const AxisAlignedBox between{{0, 0, -0.025}, {0.02, 0.01, 0.025}};
  for (int trial = 0; trial < 50; ++trial) {
    // Also hands that point straight down: their sides are vertical.
    const Eigen::Matrix3d R_WG = trial % 5 == 0 ? Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()
                                                : rng.Rotation().toRotationMatrix();
    const Pose X_WG = MakePose(R_WG, {rng.Uniform(-0.2, 0.2), rng.Uniform(-0.1, 0.1), 0.08});
    const auto found = field.Query(X_WG, sweep, between, ignored, 0.01);
    std::array<double, 3> expected{0.01, 0.01, 0.01};
    int expected_between = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      if (ignored[field.groups()[i]]) continue;
      const Vector3d p_G = X_WG.inverse() * field.points_W()[i];
      for (int k = 0; k < 3; ++k) {
        const Vector3d slabs = (p_G - sweep[k].center).cwiseAbs() - sweep[k].half_size;
        expected[k] = std::min(expected[k], slabs.maxCoeff());
      }
      const Vector3d slabs = (p_G - between.center).cwiseAbs() - between.half_size;
      expected_between += slabs.maxCoeff() < 0;
    }
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(found.distance_m[k], expected[k], 1e-12);
    EXPECT_EQ(found.between, expected_between);
    for (const double clearance_m : {0.003, 0.0, -0.002}) {
      const auto first = std::find_if(expected.begin(), expected.end(),
                                      [&](double distance_m) { return distance_m < clearance_m; });
      const auto met = field.FirstMet(X_WG, sweep, ignored, clearance_m);
      ASSERT_EQ(met.has_value(), first != expected.end()) << trial << " " << clearance_m;
      if (met) {
        EXPECT_EQ(*met, first - expected.begin());
      }
    }
  }
}

TEST(Clearance, AllBoxesOfAHandAreChecked) {
  std::vector<AxisAlignedBox> boxes;
  for (int i = 0; i < 12; ++i) boxes.push_back({{0.1 * i, 0, 0}, Vector3d::Constant(0.01)});
  const ObstacleField field({{1.1, 0, 0.013}}, {0}, 0.01);
  const auto seen = field.Query(Pose::Identity(), boxes, std::nullopt, {0}, 0.02);
  ASSERT_EQ(seen.distance_m.size(), 12u);
  EXPECT_NEAR(seen.distance_m[11], 0.003, 1e-12);
  EXPECT_EQ(seen.distance_m[10], 0.02);
  EXPECT_EQ(seen.between, 0);
}

// The distance of a tilted hand from the floor is measured at its lowest corner.
TEST(Clearance, TiltedBoxKeepsOnlyTheClearance) {
  const AxisAlignedBox finger{{0, 0, 0}, {0.01, 0.01, 0.03}};
  const auto floor = BinBoxes(Bin{});
  const Pose tilted(Eigen::AngleAxisd(0.5, Vector3d::UnitY()));
  const double reach_m = 0.01 * std::sin(0.5) + 0.03 * std::cos(0.5);
  const auto intersecting = [&](double gap_m) {
    return FindBinContact({&finger, 1}, Translation({0, 0, reach_m + gap_m}) * tilted, floor, 0.002)
        .has_value();
  };
  EXPECT_TRUE(intersecting(0.0019));
  EXPECT_FALSE(intersecting(0.0021));
}

TEST(Clearance, CoveredShareIsMeasuredInTheFloorPlan) {
  Eigen::Matrix3Xd plate(3, 40 * 40);
  std::vector<Vector3d> above;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 40; ++k) {
      plate.col(40 * i + k) = Vector3d(0.0025 * i, 0.0025 * k, 0.01);
      above.emplace_back(0.0025 * i, 0.0025 * k, i < 20 ? 0.05 : 0.005);
    }
  }
  const ObstacleField field(above, std::vector<int>(above.size(), 0), 0.01);
  EXPECT_NEAR(field.CoveredShare(plate, {0}, 0.004), 0.5, 0.1);
  EXPECT_EQ(field.CoveredShare(plate, {1}, 0.004), 0);
}

}  // namespace
}  // namespace pickbed::tests
