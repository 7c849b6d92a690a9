// Friction limits of a parallel jaw that holds one instance, compared with mechanics. Properties of
// the object are set by the test.

#include "tests/sim/held_object.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

namespace pickbed::tests {
namespace {

constexpr double kBox_m = 0.05;
constexpr double kFinger_kg = 0.2;
// More slip than kGone_m means lost; less than kStayed_m means held.
constexpr double kGone_m = 0.01;
constexpr double kStayed_m = 0.001;

struct HoldCase {
  const char* name;
  double mass_kg = 0.2;
  double friction = 0.6;
  double up_mps2 = 1;  // held for 0.4 s
  // Rotation of the hand about its closing axis, so that weight acts across the pads.
  double rotation_deg = 0;
};
void PrintTo(const HoldCase& c, std::ostream* out) { *out << c.name; }

// Returns the slip of a cube between pads that cover its sides, in metres. The grip force is
// `share` times F of 2 mu F = m (g + a).
double SlipAtShare_m(const HoldCase& c, double share, const PhysicsOptions& options = {}) {
  HandSpec spec;
  spec.finger_mass_kg = kFinger_kg;
  spec.finger_size_m.z() = 0.08;  // the palm does not touch the rotated cube
  spec.force_n = share * c.mass_kg * (kGravity_mps2 + c.up_mps2) / (2 * c.friction);
  const double center_m = 0.5 * kBox_m + 0.0005;
  const Pose around = RotatedHand(c.rotation_deg * std::numbers::pi / 180, {0, 0, center_m}) *
                      Translation({0, 0, 0.04});
  HeldObject held(BoxObject(Eigen::Vector3d::Constant(kBox_m), c.mass_kg, c.friction),
                  Translation({0, 0, center_m}), spec, around, options);
  const Pose before = held.X_GO();
  AccelerateFor(held.world, *held.hand, {0, 0, c.up_mps2}, 0.4);
  return held.Slip_m(before);
}

class FrictionLimit : public ::testing::TestWithParam<HoldCase> {};

TEST_P(FrictionLimit, LosesBelowAndHoldsAboveTheLimit) {
  EXPECT_GT(SlipAtShare_m(GetParam(), 0.94), kGone_m);
  EXPECT_LT(SlipAtShare_m(GetParam(), 1.06), kStayed_m);
}
INSTANTIATE_TEST_SUITE_P(
    Cases, FrictionLimit,
    ::testing::Values(
        HoldCase{"a tenth of a finger", 0.1 * kFinger_kg}, HoldCase{"as a finger", kFinger_kg},
        HoldCase{"five fingers", 5 * kFinger_kg}, HoldCase{"ten fingers", 10 * kFinger_kg},
        HoldCase{"ten fingers, slippery", 10 * kFinger_kg, 0.3}, HoldCase{"slippery", 0.5, 0.2},
        HoldCase{"rough", 0.5, 1.0}, HoldCase{"slow", 0.2, 0.6, 0.5}, HoldCase{"fast", 0.2, 0.6, 5},
        HoldCase{"fast, ten fingers", 10 * kFinger_kg, 0.6, 5},
        HoldCase{"turned 22.5", 0.2, 0.6, 1, 22.5}, HoldCase{"turned 45", 0.2, 0.6, 1, 45},
        HoldCase{"turned 90", 0.2, 0.6, 1, 90},
        HoldCase{"turned 45, ten fingers", 10 * kFinger_kg, 0.6, 1, 45},
        HoldCase{"turned 90, ten fingers", 10 * kFinger_kg, 0.6, 1, 90}));

// Attempts keep the contacts while the instance stays in the hand, instead of a new contact search.
TEST(HeldObject, ReusedContactsHaveTheSameLimit) {
  PhysicsOptions options;
  options.contact_reuse_m = 0.0001;
  for (const double mass_kg : {0.1 * kFinger_kg, kFinger_kg, 10 * kFinger_kg}) {
    EXPECT_GT(SlipAtShare_m({"", mass_kg}, 0.94, options), kGone_m) << mass_kg;
    EXPECT_LT(SlipAtShare_m({"", mass_kg}, 1.06, options), kStayed_m) << mass_kg;
  }
}

TEST(HeldObject, DoesNotCreep) {
  for (const double mass_kg : {0.02, 0.2, 2.0}) {
    HandSpec spec;
    spec.force_n = 1.5 * mass_kg * kGravity_mps2 / (2 * 0.6);
    HeldObject held(BoxObject(Eigen::Vector3d::Constant(kBox_m), mass_kg, 0.6),
                    Translation({0, 0, 0.0255}), spec, HandOver({0, 0, 0.014}));
    held.Lift(0.1, 1.5);
    held.Rest(0.5);
    const Pose before = held.X_GO();
    held.Rest(2.0);
    EXPECT_GT(held.world.X_WO(0).translation().z(), 0.1);
    EXPECT_LT(held.Slip_m(before), 5e-5) << mass_kg;
  }
}

// A bar held beside its center is held by the torque of two contact patches. With even pressure 2
// mu F = sqrt(w^2 + (w d / r)^2), where r is the mean lever arm of a patch (Howe and Cutkosky
// 1996).
struct TorsionCase {
  const char* name;
  double pad_m;      // width of the pads, along the bar
  double overlap_m;  // height of the patch
  double aside_m;    // d
  double mass_kg;
};
void PrintTo(const TorsionCase& c, std::ostream* out) { *out << c.name; }

constexpr double kBarFriction = 0.6;

// Returns the mean distance of a rectangle's points from its center, as a sum over a grid.
double MeanArm_m(double width_m, double height_m) {
  constexpr int kCells = 400;
  double sum = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      sum +=
          std::hypot(((i + 0.5) / kCells - 0.5) * width_m, ((j + 0.5) / kCells - 0.5) * height_m);
    }
  }
  return sum / (kCells * kCells);
}

double ForceAtLimit_n(const TorsionCase& c) {
  const double weight_n = c.mass_kg * kGravity_mps2;
  const double torsion_n = weight_n * c.aside_m / MeanArm_m(c.pad_m, c.overlap_m);
  return std::hypot(weight_n, torsion_n) / (2 * kBarFriction);
}

bool IsHeld(const TorsionCase& c, double share) {
  constexpr double kFriction = kBarFriction;
  HandSpec spec;
  spec.finger_size_m.y() = c.pad_m;
  spec.force_n = share * ForceAtLimit_n(c);
  HeldObject held(BoxObject({0.05, 0.15, 0.05}, c.mass_kg, kFriction), Translation({0, 0, 0.0255}),
                  spec, HandOver({0, c.aside_m, 0.0505 - c.overlap_m}));
  const Pose before = held.X_GO();
  held.Lift(0.1, 2.0);
  held.Rest(0.5);
  return held.Turn_rad(before) < 0.05 && held.Slip_m(before) < 0.005;
}

class Torsion : public ::testing::TestWithParam<TorsionCase> {};

TEST_P(Torsion, LimitMatchesEvenPressureOnThePatch) {
  EXPECT_FALSE(IsHeld(GetParam(), 0.85));
  EXPECT_TRUE(IsHeld(GetParam(), 1.1));
}
INSTANTIATE_TEST_SUITE_P(Cases, Torsion,
                         ::testing::Values(TorsionCase{"20 x 40", 0.02, 0.04, 0.045, 0.3},
                                           TorsionCase{"20 x 20", 0.02, 0.02, 0.045, 0.3},
                                           TorsionCase{"10 x 40", 0.01, 0.04, 0.045, 0.3},
                                           TorsionCase{"30 x 10", 0.03, 0.01, 0.045, 0.3},
                                           TorsionCase{"20 x 40, light", 0.02, 0.04, 0.045, 0.15}));

// A trough along y, held by its low wall at x = 0, between a finger inside it and a finger outside.
// The high wall is behind the inner finger, which touches only the low wall. So the torsion limit
// is given by the patch of the low wall on both pads. The center of mass is set inside the low
// wall.
std::shared_ptr<const ObjectModel> Trough(double mass_kg) {
  auto model = std::make_shared<ObjectModel>(*BoxObject({0.01, 0.15, 0.03}, mass_kg, kBarFriction));
  model->name = "trough";
  model->mesh_O = {};
  model->convex_pieces_O.clear();
  for (const auto& [low, high] :
       {std::pair(Eigen::Vector3d(-0.003, -0.075, 0), Eigen::Vector3d(0.050, 0.075, 0.006)),
        std::pair(Eigen::Vector3d(-0.003, -0.075, 0.006), Eigen::Vector3d(0.003, 0.075, 0.026)),
        std::pair(Eigen::Vector3d(0.044, -0.075, 0.006), Eigen::Vector3d(0.050, 0.075, 0.046))}) {
    const TriangleMesh box = BoxMesh({0.5 * (low + high), 0.5 * (high - low)});
    model->convex_pieces_O.push_back({box.vertices});
  }
  model->diameter_m = 0.17;
  model->mass.com_O = {0, 0, 0.013};
  return model;
}

bool TroughIsHeld(double share) {
  const TorsionCase c{"low wall", 0.02, 0.01, 0.03, 0.2};
  HandSpec spec;
  spec.finger_size_m.y() = c.pad_m;
  spec.stroke_m = 0.02;
  spec.force_n = share * ForceAtLimit_n(c);
  HeldObject held(Trough(c.mass_kg), Translation({0, 0, 0.0005}), spec,
                  HandOver({0, c.aside_m, 0.0265 - c.overlap_m}));
  const Pose before = held.X_GO();
  held.Lift(0.1, 2.0);
  held.Rest(0.5);
  return held.Turn_rad(before) < 0.05 && held.Slip_m(before) < 0.005;
}

TEST(HeldObject, TorsionOfATroughIsGivenByTheGrippedWall) {
  EXPECT_FALSE(TroughIsHeld(0.85));
  EXPECT_TRUE(TroughIsHeld(1.15));
}

// Returns a prism with 48 sides along z.
std::shared_ptr<const ObjectModel> Rod(double radius_m, double length_m, double mass_kg,
                                       double friction) {
  constexpr int kSides = 48;
  auto model = std::make_shared<ObjectModel>();
  model->name = "rod";
  model->friction = friction;
  ConvexPiece piece;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5) / kSides;
    for (const double z : {-0.5, 0.5}) {
      piece.vertices_O.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle),
                                    z * length_m);
    }
  }
  model->mesh_O.vertices = piece.vertices_O;
  for (int i = 0; i < kSides; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % kSides);
    model->mesh_O.triangles.emplace_back(a, b, a + 1);
    model->mesh_O.triangles.emplace_back(b, b + 1, a + 1);
  }
  model->convex_pieces_O.push_back(piece);
  model->diameter_m = std::hypot(2 * radius_m, length_m);
  const double across = mass_kg * (3 * radius_m * radius_m + length_m * length_m) / 12;
  model->mass.mass_kg = mass_kg;
  model->mass.volume_m3 = std::numbers::pi * radius_m * radius_m * length_m;
  model->mass.inertia_com_O =
      Eigen::Vector3d(across, across, 0.5 * mass_kg * radius_m * radius_m).asDiagonal();
  return model;
}

// The rod is along y, so the pads touch its two sides in lines.
TEST(HeldObject, RodGrippedAcrossItsAxisHasTheSameLimit) {
  constexpr double kRadius_m = 0.015, kMass_kg = 0.3, kFriction = 0.5, kUp_mps2 = 1;
  const Eigen::Matrix3d along_y =
      Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()).matrix();
  for (const double share : {0.94, 1.06}) {
    HandSpec spec;
    spec.force_n = share * kMass_kg * (kGravity_mps2 + kUp_mps2) / (2 * kFriction);
    HeldObject held(Rod(kRadius_m, 0.1, kMass_kg, kFriction),
                    MakePose(along_y, {0, 0, kRadius_m + 0.0005}), spec, HandOver({0, 0, 0.006}));
    const Pose before = held.X_GO();
    AccelerateFor(held.world, *held.hand, {0, 0, kUp_mps2}, 0.4);
    if (share < 1) {
      EXPECT_GT(held.Slip_m(before), kGone_m);
    } else {
      EXPECT_LT(held.Slip_m(before), kStayed_m);
      EXPECT_LT(held.Turn_rad(before), 0.02);
    }
  }
}

TEST(HeldObject, SmallObjectsAreHeld) {
  constexpr double kSize_m = 0.015, kMass_kg = 0.010;
  for (const double force_n : {1.0, 10.0, 40.0}) {
    HandSpec spec;
    spec.force_n = force_n;
    HeldObject held(BoxObject(Eigen::Vector3d::Constant(kSize_m), kMass_kg, 0.6),
                    Translation({0, 0, 0.5 * kSize_m + 0.0003}), spec, HandOver({0, 0, 0.003}));
    const Pose before = held.X_GO();
    held.Lift(0.1, 0.5);
    held.Rest(2.0);
    EXPECT_LT(held.Slip_m(before), 2e-4) << force_n;
    EXPECT_LT(held.Turn_rad(before), 0.02) << force_n;
  }
}

}  // namespace
}  // namespace pickbed::tests
