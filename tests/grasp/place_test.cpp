#include "grasp/place.h"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/hand_joints.h"
#include "tests/grasp/grasp_scenes.h"

namespace pickbed {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

// A plate of 60 x 40 x 10 mm that can lie on its two large sides.
std::shared_ptr<const ObjectModel> Plate() {
  auto plate = std::make_shared<ObjectModel>(*BoxPart({0.06, 0.04, 0.01}, 0.1));
  plate->resting_O = {{Vector3d::UnitZ(), 0.5}, {-Vector3d::UnitZ(), 0.5}};
  return plate;
}

Pose Tilted(double angle_rad, const Vector3d& p_W) {
  return Translation(p_W) * Pose(AngleAxisd(angle_rad, Vector3d::UnitY()));
}

TEST(PlanPlace, LaysTheTiltedPartDownBesideTheBinAndTheHandWithIt) {
  const auto plate = Plate();
  const Pose X_WO = Tilted(0.4, {0.05, 0.02, 0.05});
  const Pose X_WG = FromAbove({0.05, 0.02, 0.045});
  const PlacePlan plan = PlanPlace(Bin{}, *plate, X_WO, X_WG, HandBoxes({}, 0.05));
  EXPECT_NEAR(plan.X_WO.linear().col(2).z(), 1, 1e-9);
  EXPECT_NEAR(plan.X_WO.translation().z(), 0.005, 1e-9);
  // Outside the bin, on the table.
  EXPECT_GT(plan.X_WO.translation().x(), 0.5 * Bin{}.inner_size_m.x() + 0.1);
  const Vector3d from_table = plan.X_WO.translation() - plan.table_W.center;
  EXPECT_TRUE((from_table.head<2>().cwiseAbs().array() < 0.04).all());
  EXPECT_NEAR(plan.table_W.center.z() + plan.table_W.half_size.z(), 0, 1e-12);
  // Hand and part keep their places to each other but for the height that is left to fall.
  const Pose X_OG = X_WO.inverse() * X_WG, X_OG_place = plan.X_WO.inverse() * plan.X_WG;
  EXPECT_TRUE(X_OG.linear().isApprox(X_OG_place.linear(), 1e-9));
  const Vector3d up_W = plan.X_WO.linear() * (X_OG_place.translation() - X_OG.translation());
  EXPECT_LT(up_W.head<2>().norm(), 1e-9);
  EXPECT_GE(up_W.z(), 0.001 - 1e-9);
}

TEST(PlanPlace, FingersBelowThePartStayOffTheTable) {
  const Pose X_WO = Translation({0, 0, 0.05});
  const Pose X_WG = FromAbove({0, 0, 0.038});  // tips 12 mm below the plate's middle
  const PlacePlan plan = PlanPlace(Bin{}, *Plate(), X_WO, X_WG, HandBoxes({}, 0.05));
  EXPECT_NEAR(plan.X_WG.translation().z(), 0.001, 1e-9);
}

// Held from the side the plate may go down on either face; the one that turns the hand up is not
// it.
TEST(PlanPlace, OfTwoWaysToLieTheHandsIsChosen) {
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

TEST(PlaceError, IsWhatWasAdded) {
  const auto plate = Plate();
  const Pose wanted = Tilted(0.3, {0.3, 0, 0.02});
  const Pose real =
      Translation({0.003, -0.004, 0}) * wanted * Pose(AngleAxisd(0.2, Vector3d::UnitZ()));
  const PlaceError error = PlaceErrorOf(*plate, wanted, real);
  EXPECT_NEAR(error.distance_m, 0.005, 1e-9);
  EXPECT_NEAR(error.turn_rad, 0.2, 1e-9);
}

TEST(PlaceError, ATurnOntoItselfIsNone) {
  auto plate = std::make_shared<ObjectModel>(*Plate());
  const Pose half(AngleAxisd(std::numbers::pi, Vector3d::UnitZ()));
  const Pose wanted = Translation({0.3, 0, 0.005});
  EXPECT_NEAR(PlaceErrorOf(*plate, wanted, wanted * half).turn_rad, std::numbers::pi, 1e-6);
  plate->symmetries_O.discrete_O = {half};
  EXPECT_LT(PlaceErrorOf(*plate, wanted, wanted * half).turn_rad, 1e-6);
  // An axis that lies beside O: the distance is of what lies there, not of O.
  plate->mass.com_O = {0.01, 0, 0};
  plate->symmetries_O = {{}, {{Vector3d::UnitZ(), {0.01, 0, 0}}}};
  const Pose turned = TurnAbout(plate->symmetries_O.continuous_O[0], 1.0);
  const PlaceError error = PlaceErrorOf(*plate, wanted, wanted * turned);
  EXPECT_LT(error.turn_rad, 0.05);
  EXPECT_LT(error.distance_m, 1e-9);
}

}  // namespace
}  // namespace pickbed
