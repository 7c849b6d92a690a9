#include "grasp/place/placement.h"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/hands/jaw_hand.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed::tests {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

// A plate of 60 x 40 x 10 mm that can rest on its two large sides.
std::shared_ptr<const ObjectModel> Plate() {
  auto plate = std::make_shared<ObjectModel>(*BoxObject({0.06, 0.04, 0.01}, 0.1));
  plate->resting_O = {{Vector3d::UnitZ(), 0.5}, {-Vector3d::UnitZ(), 0.5}};
  return plate;
}

Pose Tilted(double angle_rad, const Vector3d& p_W) {
  return Translation(p_W) * Pose(AngleAxisd(angle_rad, Vector3d::UnitY()));
}

TEST(PlanPlace, PlacesTheTiltedObjectFlatBesideTheBin) {
  const auto plate = Plate();
  const Pose X_WO = Tilted(0.4, {0.05, 0.02, 0.05});
  const Pose X_WG = FromAbove({0.05, 0.02, 0.055}, 0.5 * std::numbers::pi);
  const PlacePlan plan = PlanPlace(Bin{}, *plate, X_WO, X_WG, HandBoxes({}, 0.05));
  EXPECT_NEAR(plan.X_WO.linear().col(2).z(), 1, 1e-9);
  EXPECT_NEAR(plan.X_WO.translation().z(), 0.005, 1e-9);
  // Outside the bin, on the table.
  EXPECT_GT(plan.X_WO.translation().x(), 0.5 * Bin{}.inner_size_m.x() + 0.1);
  const Vector3d from_table = plan.X_WO.translation() - plan.table_W.center;
  EXPECT_TRUE((from_table.head<2>().cwiseAbs().array() < 0.04).all());
  EXPECT_NEAR(plan.table_W.center.z() + plan.table_W.half_size.z(), 0, 1e-12);
  // Hand and object keep their relative pose, and the object does not drop.
  const Pose X_OG = X_WO.inverse() * X_WG, X_OG_place = plan.X_WO.inverse() * plan.X_WG;
  EXPECT_TRUE(X_OG.linear().isApprox(X_OG_place.linear(), 1e-9));
  const Vector3d up_W = plan.X_WO.linear() * (X_OG_place.translation() - X_OG.translation());
  EXPECT_LT(up_W.norm(), 1e-9);
}

TEST(PlanPlace, FingersBelowTheObjectDoNotTouchTheTable) {
  const Pose X_WO = Translation({0, 0, 0.05});
  const Pose X_WG = FromAbove({0, 0, 0.038});  // tips 12 mm below the center of the plate
  const PlacePlan plan = PlanPlace(Bin{}, *Plate(), X_WO, X_WG, HandBoxes({}, 0.05));
  EXPECT_NEAR(plan.X_WG.translation().z(), 0.001, 1e-9);
}

// Held from the side, the plate can be placed on either face. The face that makes the hand point up
// is not selected.
TEST(PlanPlace, SelectsTheFaceThatLetsTheHandPointDown) {
  const Pose X_WO = Tilted(1.3, {0, 0, 0.06});
  for (const double side : {1.0, -1.0}) {
    Eigen::Matrix3d R_OG;
    R_OG.col(0) = Vector3d::UnitY();
    R_OG.col(2) = -side * Vector3d::UnitZ();
    R_OG.col(1) = R_OG.col(2).cross(R_OG.col(0));
    const PlacePlan plan = PlanPlace(
        Bin{}, *Plate(), X_WO, X_WO * MakePose(R_OG, {0, 0, side * 0.002}), HandBoxes({}, 0.05));
    EXPECT_NEAR(plan.X_WG.linear().col(2).z(), -1, 1e-6);
    EXPECT_NEAR(plan.X_WO.linear().col(2).z(), side, 1e-6);
  }
}

// The symmetries make all four long sides resting sides, though only one is listed. So a hand that
// holds the bar from above stays upright.
TEST(PlanPlace, RestingDirectionIncludesItsSymmetricImages) {
  auto bar = std::make_shared<ObjectModel>(*BoxObject({0.02, 0.02, 0.08}, 0.1));
  bar->resting_O = {{Vector3d::UnitX(), 1}};
  const Pose X_WO = Translation({0, 0, 0.05}) * Pose(AngleAxisd(1.5, Vector3d::UnitX()));
  const Pose X_WG = FromAbove({0, 0, 0.045});
  const auto down = [&] {
    return -PlanPlace(Bin{}, *bar, X_WO, X_WG, HandBoxes({}, 0.03)).X_WG.linear()(2, 2);
  };
  EXPECT_LT(down(), 0.1);
  bar->symmetries_O.discrete_O = {Pose(AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ())),
                                  Pose(AngleAxisd(std::numbers::pi, Vector3d::UnitZ())),
                                  Pose(AngleAxisd(-0.5 * std::numbers::pi, Vector3d::UnitZ()))};
  EXPECT_GT(down(), 0.99);
}

// The block is half-way between two sides.
TEST(PlanPlace, SelectsTheMoreProbableDirection) {
  auto block = std::make_shared<ObjectModel>(*BoxObject({0.04, 0.05, 0.04}, 0.1));
  const Pose X_WO = Tilted(0.25 * std::numbers::pi, {0, 0, 0.05});
  const Pose X_WG = FromAbove({0, 0, 0.05}, 0.5 * std::numbers::pi);
  for (const bool z_is_likely : {true, false}) {
    block->resting_O = {{Vector3d::UnitZ(), z_is_likely ? 0.8 : 0.2},
                        {-Vector3d::UnitX(), z_is_likely ? 0.2 : 0.8}};
    const PlacePlan plan = PlanPlace(Bin{}, *block, X_WO, X_WG, HandBoxes({}, 0.056));
    EXPECT_NEAR(plan.X_WO.linear()(2, z_is_likely ? 2 : 0), z_is_likely ? 1 : -1, 1e-9);
  }
}

// An upright plate held from above: if it were laid flat, the hand would hit the table. It is
// released inclined, on the corner about which it tips to its final pose, and the hand stays clear.
TEST(PlanPlace, ReleasesInclinedIfTheHandWouldHitTheTable) {
  const auto plate = Plate();
  const Pose X_WO = Tilted(1.3, {0, 0, 0.05});
  const Pose X_WG = FromAbove({0, 0, 0.06}, 0);
  const auto boxes = HandBoxes({}, 0.016);
  const PlacePlan plan = PlanPlace(Bin{}, *plate, X_WO, X_WG, boxes);
  EXPECT_NEAR(std::abs(plan.X_WO.linear()(2, 2)), 1, 1e-9);
  const Pose X_WO_release = plan.X_WG * X_WG.inverse() * X_WO;
  const double inclined_rad = RotationAngleRad(X_WO_release.linear(), plan.X_WO.linear());
  EXPECT_GT(inclined_rad, 0.1);
  EXPECT_LT(inclined_rad, PlaceOptions{}.tip_rad);
  double lowest_m = 1;
  Vector3d low_O = Vector3d::Zero();
  for (const Vector3d& p_O : plate->mesh_O.vertices) {
    if ((X_WO_release * p_O).z() < lowest_m) low_O = p_O;
    lowest_m = std::min(lowest_m, (X_WO_release * p_O).z());
  }
  EXPECT_LT((X_WO_release * low_O - plan.X_WO * low_O).head<2>().norm(), 1e-9);
}

// Four grasps of the plate: from straight above its more probable side, from above the other side,
// tilted, and by fingers that extend 12 mm past it, so that it must drop.
TEST(SetDownWorths, FallWithTiltDropAndProbability) {
  auto plate = std::make_shared<ObjectModel>(*Plate());
  plate->resting_O = {{Vector3d::UnitZ(), 0.8}, {-Vector3d::UnitZ(), 0.2}};
  const Pose over(AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
  const Pose above = FromAbove({0, 0, -0.004});
  const std::vector<Pose> X_OG{above, over * above,
                               Pose(AngleAxisd(0.8, Vector3d::UnitY())) * above,
                               FromAbove({0, 0, -0.016})};
  const std::vector<std::vector<AxisAlignedBox>> boxes(X_OG.size(), HandBoxes({}, 0.07));
  const auto worths = SetDownWorths(*plate, X_OG, boxes);
  EXPECT_NEAR(worths[0], 1, 1e-9);
  EXPECT_NEAR(worths[1], 0.25, 1e-9);
  EXPECT_LT(worths[2], 0.8);
  EXPECT_GT(worths[2], 0);
  const PlaceOptions options;
  const double drop_m = 0.011 + options.clearance_m;
  EXPECT_NEAR(worths[3], options.good_drop_m / (options.good_drop_m + drop_m), 1e-9);
}

// At this height, the lowest point of hand and object during the rotation is exactly the clearance
// above the rim.
TEST(CarryHeight, ClearsTheRimDuringTheRotation) {
  Bin bin;
  bin.inner_size_m.z() = 0.4;
  const auto object = BoxObject({0.02, 0.03, 0.2}, 0.1);
  const auto boxes = HandBoxes({}, 0.03);
  const Pose from = FromAbove({0, 0, 0.1});
  const Pose to =
      Translation({0.5, 0, 0.02}) * Pose(AngleAxisd(1.2, Vector3d::UnitY())) * Pose(from.linear());
  const Pose X_GO = Translation({0, 0, 0.02}) * Pose(AngleAxisd(0.7, Vector3d::UnitX()));
  const PlaceOptions options;
  const double height_m = CarryHeight_m(bin, *object, X_GO, from, to, boxes, options);
  double lowest_m = 1;
  const Eigen::Quaterniond start(from.linear()), end(to.linear());
  for (int i = 0; i <= 100; ++i) {
    const Pose X_WG =
        MakePose(start.slerp(0.01 * i, end).toRotationMatrix(), Vector3d(0, 0, height_m));
    for (const Vector3d& p_O : object->mesh_O.vertices) {
      lowest_m = std::min(lowest_m, (X_WG * X_GO * p_O).z());
    }
    for (const AxisAlignedBox& box : boxes) {
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const Vector3d p_G = box.center + sign.cwiseProduct(box.half_size);
        lowest_m = std::min(lowest_m, (X_WG * p_G).z());
      }
    }
  }
  EXPECT_NEAR(lowest_m, 0.4 + options.rim_clearance_m, 0.001);
}

TEST(PlaceError, EqualsThePlantedError) {
  const auto plate = Plate();
  const Pose wanted = Tilted(0.3, {0.3, 0, 0.02});
  const Pose real =
      Translation({0.003, -0.004, 0}) * wanted * Pose(AngleAxisd(0.2, Vector3d::UnitZ()));
  const PlaceError error = PlaceErrorOf(*plate, wanted, real, plate->mass.com_O);
  EXPECT_NEAR(error.distance_m, 0.005, 1e-9);
  EXPECT_NEAR(error.rotation_error_rad, 0.2, 1e-9);
}

TEST(PlaceError, SymmetryRotationIsNoError) {
  auto plate = std::make_shared<ObjectModel>(*Plate());
  const Pose half(AngleAxisd(std::numbers::pi, Vector3d::UnitZ()));
  const Pose wanted = Translation({0.3, 0, 0.005});
  EXPECT_NEAR(PlaceErrorOf(*plate, wanted, wanted * half, plate->mass.com_O).rotation_error_rad,
              std::numbers::pi, 1e-6);
  plate->symmetries_O.discrete_O = {half};
  EXPECT_LT(PlaceErrorOf(*plate, wanted, wanted * half, plate->mass.com_O).rotation_error_rad,
            1e-6);
  // The axis is beside O. The distance is measured at the center of mass, not at O.
  plate->mass.com_O = {0.01, 0, 0};
  plate->symmetries_O = {{}, {{Vector3d::UnitZ(), {0.01, 0, 0}}}};
  const Pose rotated = TurnAbout(plate->symmetries_O.continuous_O[0], 1.0);
  const PlaceError error = PlaceErrorOf(*plate, wanted, wanted * rotated, plate->mass.com_O);
  EXPECT_LT(error.rotation_error_rad, 0.05);
  EXPECT_LT(error.distance_m, 1e-9);
}

}  // namespace
}  // namespace pickbed::tests
