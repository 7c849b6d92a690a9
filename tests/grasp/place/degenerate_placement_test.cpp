// Boxes without volume, motions without length, and placements of points, lines and plates.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "grasp/place/boxes_apart.h"
#include "grasp/place/hand_motion.h"
#include "grasp/place/placement.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kHalfTurn = std::numbers::pi;

AxisAlignedBox BoxOf(const Vector3d& half_size) { return {Vector3d::Zero(), half_size}; }

TEST(DegenerateBoxes, PointsAreApartUnlessTheyAreEqual) {
  const AxisAlignedBox dot = BoxOf(Vector3d::Zero());
  for (const double turn_rad : {0.0, 0.7, kHalfTurn}) {
    const auto at = [&](const Vector3d& p) {
      return MakePose(Eigen::AngleAxisd(turn_rad, Vector3d(1, 2, 3).normalized()).matrix(), p);
    };
    EXPECT_FALSE(BoxesApart(dot, dot, at({0, 0, 0})));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_TRUE(BoxesApart(dot, dot, at(1e-9 * Vector3d::Unit(axis))));
    }
    const AxisAlignedBox cube = BoxOf({1, 1, 1});
    EXPECT_FALSE(BoxesApart(cube, dot, at({0.9, -0.9, 0.9})));
    EXPECT_TRUE(BoxesApart(cube, dot, at({0.9, -0.9, 1.1})));
    EXPECT_FALSE(BoxesApart(dot, cube, at({0.1, 0.2, 0.3})));
  }
}

TEST(DegenerateBoxes, SegmentsAndPlatesMeetWhereTheyCross) {
  const AxisAlignedBox along_x = BoxOf({1, 0, 0}), along_y = BoxOf({0, 1, 0}),
                       plate = BoxOf({1, 1, 0});
  EXPECT_FALSE(BoxesApart(along_x, along_y, Translation({0.5, 0.5, 0})));
  EXPECT_TRUE(BoxesApart(along_x, along_y, Translation({0.5, 0.5, 1e-9}))) << "skew";
  EXPECT_TRUE(BoxesApart(along_x, along_x, Translation({0, 1e-9, 0}))) << "parallel";
  EXPECT_TRUE(BoxesApart(along_x, along_x, Translation({2.1, 0, 0}))) << "in line";
  EXPECT_FALSE(BoxesApart(along_x, along_x, Translation({1.9, 0, 0})));
  EXPECT_TRUE(BoxesApart(plate, plate, Translation({0, 0, 1e-9})));
  EXPECT_FALSE(BoxesApart(plate, plate, Translation({1.9, 1.9, 0})));
  const auto upright = [&](double x) {
    return MakePose(Eigen::AngleAxisd(0.5 * kHalfTurn, Vector3d::UnitY()).matrix(), {x, 0, 0});
  };
  EXPECT_FALSE(BoxesApart(plate, plate, upright(0.9)));
  EXPECT_TRUE(BoxesApart(plate, plate, upright(1.1)));
  const auto turned = [&](double x) {
    return MakePose(Eigen::AngleAxisd(0.6, Vector3d::UnitZ()).matrix(), {x, 0, 0});
  };
  EXPECT_FALSE(BoxesApart(along_x, along_x, turned(0.2)));
  EXPECT_TRUE(BoxesApart(along_x, along_x, turned(1.2)));
}

// The intervals of both boxes overlap along all their axes.
TEST(DegenerateBoxes, OnlyTheCommonNormalSeparatesSkewSegments) {
  const AxisAlignedBox along_x = BoxOf({1, 1e-9, 1e-9}), along_y = BoxOf({0, 1, 0});
  const auto diagonal = [&](const Vector3d& p) {
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(0.25 * kHalfTurn, Vector3d::UnitX()) *
                               Eigen::AngleAxisd(0.25 * kHalfTurn, Vector3d::UnitY()))
                                  .toRotationMatrix();
    return MakePose(R, p);
  };
  EXPECT_TRUE(BoxesApart(along_x, along_y, diagonal({0, 0.3, -0.3})));
  EXPECT_FALSE(BoxesApart(along_x, along_y, diagonal({0, 0.3, 0.3}))) << "it passes the origin";
}

TEST(DegenerateMotions, WithoutAWayTheHandRests) {
  EXPECT_EQ(MinimumJerk(0), 0);
  EXPECT_EQ(MinimumJerk(1), 1);
  EXPECT_EQ(MinimumJerkSeconds(0, 0.4), 0);
  EXPECT_TRUE(LiftMotion({0.03, -0.02}, 0).isZero());
  EXPECT_EQ(LiftMotion({0, 0}, 0.2), Vector3d(0, 0, 0.2));
  EXPECT_TRUE(LiftMotion({0.03, -0.02}, 1e6).isApprox(Vector3d(0.03, -0.02, 1e6)));
  const Pose pose = FromAbove({0.1, 0.2, 0.3}, 0.4);
  for (const double share : {0.0, 0.3, 1.0}) {
    EXPECT_TRUE(Between(pose, pose, share).isApprox(pose, 1e-12)) << share;
  }
}

TEST(DegenerateMotions, HalfATurnIsShared) {
  const Pose from = FromAbove({0, 0, 0});
  for (int axis = 0; axis < 3; ++axis) {
    const Pose to = from * Eigen::AngleAxisd(kHalfTurn, Vector3d::Unit(axis));
    for (const double share : {0.0, 0.25, 0.5, 1.0}) {
      const Eigen::Matrix3d R = Between(from, to, share).linear();
      EXPECT_TRUE((R * R.transpose()).isIdentity(1e-12));
      EXPECT_NEAR(RotationAngleRad(from.linear(), R), share * kHalfTurn, 1e-6);
      EXPECT_NEAR(RotationAngleRad(R, to.linear()), (1 - share) * kHalfTurn, 1e-6);
    }
  }
}

// Objects of one point, equal points, a line and a plate, as vertices of a mesh.
std::vector<ObjectModel> FlatObjects() {
  const std::vector<std::vector<Vector3d>> vertices{
      {{0, 0, 0}},
      std::vector<Vector3d>(9, Vector3d(0.01, 0.02, 0.03)),
      {{-0.02, 0, 0}, {0, 0, 0}, {0.02, 0, 0}},
      {{-0.02, -0.02, 0}, {0.02, -0.02, 0}, {0.02, 0.02, 0}, {-0.02, 0.02, 0}}};
  std::vector<ObjectModel> objects;
  for (const auto& points : vertices) {
    ObjectModel& model = objects.emplace_back();
    model.mesh_O.vertices = points;
    model.diameter_m = Diameter(model.mesh_O);
  }
  return objects;
}

double LowestVertex_m(const ObjectModel& model, const Pose& X_WO) {
  double lowest_m = 1e9;
  for (const Vector3d& p_O : model.mesh_O.vertices) {
    lowest_m = std::min(lowest_m, (X_WO * p_O).z());
  }
  return lowest_m;
}

TEST(DegeneratePlacement, FlatObjectsRestOnTheTable) {
  const ParallelJaw jaw = SmallJaw();
  const std::vector<AxisAlignedBox> boxes = jaw.Boxes(0);
  const PlaceOptions options;
  for (const ObjectModel& model : FlatObjects()) {
    for (const double turn_rad : {0.0, 0.4, kHalfTurn}) {
      const Pose X_WO =
          MakePose(Eigen::AngleAxisd(turn_rad, Vector3d::UnitX()).matrix(), {0.05, 0.02, 0.04});
      for (const std::span<const AxisAlignedBox>& hand :
           {std::span<const AxisAlignedBox>(boxes), std::span<const AxisAlignedBox>()}) {
        const PlacePlan plan = PlanPlace({}, model, X_WO, FromAbove({0.05, 0.02, 0.03}), hand);
        EXPECT_TRUE(plan.X_WG.matrix().allFinite());
        EXPECT_NEAR(plan.X_WG.linear().determinant(), 1, 1e-9);
        EXPECT_NEAR(LowestVertex_m(model, plan.X_WO), 0, 1e-9);
        EXPECT_TRUE(plan.overtravel_m >= 0 && plan.overtravel_m <= options.overtravel_m);
        for (const AxisAlignedBox& box : hand) {
          const double lowest_m = (plan.X_WG * box.center).z() -
                                  plan.X_WG.linear().row(2).cwiseAbs().dot(box.half_size);
          EXPECT_GE(lowest_m, options.clearance_m - 1e-9) << "the hand touches the table";
        }
      }
    }
  }
}

TEST(DegeneratePlacement, AHeldPointIsCarriedOverTheRim) {
  const Bin bin;
  const ObjectModel point = FlatObjects()[0];
  const double clear_m = bin.inner_size_m.z() + PlaceOptions().rim_clearance_m;
  const Pose X_WG = FromAbove({0, 0, 0.1});
  const auto height_m = [&](const Pose& X_GO) {
    return CarryHeight_m(bin, point, X_GO, X_WG, X_WG, {});
  };
  EXPECT_NEAR(height_m(Pose::Identity()), clear_m, 1e-12) << "at the origin of G";
  EXPECT_NEAR(height_m(Translation({0, 0, 0.04})), clear_m + 0.04, 1e-12) << "below it";
  EXPECT_NEAR(height_m(Translation({0, 0, -0.04})), clear_m, 1e-12) << "above it";
}

TEST(DegeneratePlacement, WorthsAreSharesWithoutProbableSides) {
  const ParallelJaw jaw = SmallJaw();
  const std::vector<Pose> X_OG{FromAbove({0, 0, 0}), FromAbove({0, 0, 0}).inverse()};
  const std::vector<std::vector<AxisAlignedBox>> boxes(X_OG.size(), jaw.Boxes(0.01));
  for (ObjectModel& model : FlatObjects()) {
    EXPECT_TRUE(SetDownWorths(model, {}, {}).empty());
    for (const double worth : SetDownWorths(model, X_OG, boxes)) {
      EXPECT_TRUE(worth >= 0 && worth <= 1) << worth;
    }
    // An object file may give no side a probability.
    model.resting_O = {{Vector3d::UnitZ(), 0}, {Vector3d::UnitX(), 0}};
    for (const double worth : SetDownWorths(model, X_OG, boxes)) EXPECT_EQ(worth, 0);
  }
}

TEST(DegeneratePlacement, ErrorsOfEqualAndOppositePoses) {
  const ObjectModel point = FlatObjects()[0];
  const Pose X_WO = FromAbove({0.1, 0.2, 0.3}, 0.4);
  const PlaceError none = PlaceErrorOf(point, X_WO, X_WO, Vector3d::Zero());
  EXPECT_EQ(none.distance_m, 0);
  EXPECT_NEAR(none.rotation_error_rad, 0, 1e-7);
  const Pose opposite = X_WO * Eigen::AngleAxisd(kHalfTurn, Vector3d::UnitZ());
  EXPECT_NEAR(PlaceErrorOf(point, X_WO, opposite, Vector3d::Zero()).rotation_error_rad, kHalfTurn,
              1e-7);
}

}  // namespace
}  // namespace pickbed::tests
