// Contacts of a jaw with surfaces that have no points, one point, or points on a line.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "grasp/candidates/jaw_wrenches.h"
#include "grasp/candidates/pad_contact.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kBand_m = 0.001;
constexpr double kPointArea_m2 = 1e-6;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
// The origin of O is between the pads, 20 mm behind the tips.
const Pose kAroundOrigin = Translation({0, 0, 0.02});

SurfacePoints SurfaceWith(const std::vector<std::pair<Vector3d, Vector3d>>& points) {
  SurfacePoints surface;
  surface.points_O.resize(static_cast<Eigen::Index>(points.size()), 3);
  surface.normals_O.resize(static_cast<Eigen::Index>(points.size()), 3);
  surface.area_m2 = kPointArea_m2;
  for (size_t i = 0; i < points.size(); ++i) {
    surface.points_O.row(static_cast<Eigen::Index>(i)) = points[i].first.cast<float>().transpose();
    surface.normals_O.row(static_cast<Eigen::Index>(i)) =
        points[i].second.cast<float>().transpose();
  }
  return surface;
}

// A point whose two sides face the two pads, such as a plate without thickness.
SurfacePoints TwoSidedPoint() {
  return SurfaceWith(
      {{Vector3d::Zero(), Vector3d::UnitX()}, {Vector3d::Zero(), -Vector3d::UnitX()}});
}

PadContact Closed(const SurfacePoints& surface, const HandSpec& hand = {}) {
  return ClosePads(surface, Rotated(surface.points_O, kAroundOrigin.linear()), kAroundOrigin, hand,
                   kBand_m);
}

std::array<PadPatch, 2> Touched(const SurfacePoints& surface, const HandSpec& hand = {}) {
  return TouchedPatches(surface, Rotated(surface.points_O, kAroundOrigin.linear()), kAroundOrigin,
                        hand, Closed(surface, hand), kBand_m);
}

TEST(DegenerateContacts, AHandTouchesNothingWithoutPoints) {
  const SurfacePoints none = SurfaceWith({});
  const PointColumns turned = Rotated(none.points_O, FromAbove({0, 0, 0}).linear());
  EXPECT_EQ(turned.rows(), 0);
  EXPECT_FALSE(Closed(none).touches);
  EXPECT_EQ(Closed(none).width_m(), 0);
  for (const PadPatch& patch : Touched(none)) {
    EXPECT_TRUE(patch.points_G.empty());
    EXPECT_TRUE(patch.normal_G.isZero());
  }
  EXPECT_TRUE(HandClearsObject(turned, kAroundOrigin, HandBoxes({}, 0.05), 0.01));
}

TEST(DegenerateContacts, SurfaceThatFacesOnlyOnePadIsNoContact) {
  for (const Vector3d& normal :
       {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, -1)}) {
    const SurfacePoints one = SurfaceWith({{Vector3d::Zero(), normal}});
    EXPECT_FALSE(Closed(one).touches) << normal.transpose();
  }
  // Faces along the closing direction slide between the pads.
  const SurfacePoints along = SurfaceWith({{{0.01, 0, 0}, Vector3d::UnitY()},
                                           {{-0.01, 0, 0}, -Vector3d::UnitY()},
                                           {{0, 0, 0.005}, Vector3d::UnitZ()}});
  EXPECT_FALSE(Closed(along).touches);
}

TEST(DegenerateContacts, BothSidesOfAPointAreAContactWithoutWidth) {
  for (const int copies : {1, 30}) {
    std::vector<std::pair<Vector3d, Vector3d>> points;
    for (int i = 0; i < copies; ++i) {
      points.emplace_back(Vector3d::Zero(), Vector3d::UnitX());
      points.emplace_back(Vector3d::Zero(), -Vector3d::UnitX());
    }
    const PadContact contact = Closed(SurfaceWith(points));
    ASSERT_TRUE(contact.touches);
    EXPECT_EQ(contact.width_m(), 0);
    EXPECT_EQ(contact.max_angle_rad, 0);
    EXPECT_NEAR(contact.area_m2, copies * kPointArea_m2, 1e-12);
    EXPECT_TRUE(contact.shared());
    EXPECT_NEAR((contact.shared_center() - Eigen::Vector2d(0, -0.02)).norm(), 0, 1e-8);
    for (const PadPatch& patch : Touched(SurfaceWith(points))) {
      ASSERT_EQ(patch.points_G.size(), static_cast<size_t>(copies));
      EXPECT_EQ(std::abs(patch.normal_G.x()), 1);
      const std::vector<Vector3d> rim = RimPoints(patch);
      ASSERT_EQ(rim.size(), 1u);
      EXPECT_NEAR((rim[0] - Vector3d(0, 0, -0.02)).norm(), 0, 1e-8);
    }
  }
}

TEST(DegenerateContacts, AJawWithoutStrokeTouchesOnlyItsMiddlePlane) {
  HandSpec closed;
  closed.stroke_m = 0;
  EXPECT_TRUE(Closed(TwoSidedPoint(), closed).touches);
  const SurfacePoints beside =
      SurfaceWith({{{1e-4, 0, 0}, Vector3d::UnitX()}, {{-1e-4, 0, 0}, -Vector3d::UnitX()}});
  EXPECT_TRUE(Closed(beside).touches);
  EXPECT_FALSE(Closed(beside, closed).touches);
  EXPECT_EQ(JawOpening_m(closed, 0, 0), 0);
  EXPECT_FALSE(JawOpening_m(closed, 0, 1e-9));
}

TEST(DegenerateContacts, OnlyAWidthThatIsANumberHasAnOpening) {
  const HandSpec hand;
  EXPECT_EQ(JawOpening_m(hand, 0.003, 0), 0.006);
  EXPECT_FALSE(JawOpening_m(hand, 0.003, kNoNumber));
  EXPECT_FALSE(JawOpening_m(hand, 0.003, std::numeric_limits<double>::infinity()));
}

TEST(DegenerateContacts, BoxesWithoutVolumeMeetOnlyWhatIsBeforeThem) {
  const PointColumns point = SurfaceWith({{Vector3d::Zero(), Vector3d::UnitX()}}).points_O;
  const auto clears = [&](const Vector3d& center_G, double margin_m) {
    const AxisAlignedBox dot{center_G, Vector3d::Zero()};
    return HandClearsObject(point, Pose::Identity(), {&dot, 1}, margin_m);
  };
  EXPECT_TRUE(clears({0, 0, 0.01}, 0)) << "a point has no area across the approach";
  EXPECT_FALSE(clears({0, 0, 0.01}, 0.001)) << "it passed the point";
  EXPECT_TRUE(clears({0, 0, -0.01}, 0.001)) << "it has not reached the point";
  EXPECT_TRUE(clears({0.01, 0, 0.01}, 0.001));
  EXPECT_TRUE(HandClearsObject(point, Pose::Identity(), {}, 1)) << "no boxes";
}

TEST(DegenerateContacts, RimOfALineIsItsEndsAtTheMeanDistance) {
  PadPatch line;
  for (const double y_mm : {-2, -1, 0, 1, 2}) line.points_G.emplace_back(0.01, 1e-3 * y_mm, 0);
  const std::vector<Vector3d> rim = RimPoints(line);
  ASSERT_EQ(rim.size(), 2u);
  for (const Vector3d& p : rim) {
    EXPECT_NEAR(std::abs(p.y()), 1.2e-3, 1e-12) << "mean of 2, 1, 0, 1 and 2 mm";
    EXPECT_NEAR((p - Vector3d(0.01, p.y(), 0)).norm(), 0, 1e-12);
  }
  EXPECT_TRUE(RimPoints(PadPatch()).empty());
}

TEST(DegenerateContacts, ContactsAtTheCenterOfMassResistNoTorque) {
  const auto box = BoxObject({0.05, 0.05, 0.05}, 0.2);
  const HandSpec hand;
  const SurfacePoints surface = TwoSidedPoint();
  const RobustOptions options;
  const auto set = JawHold{*box, hand, surface, options}.At(kAroundOrigin, 0.006, 1);
  ASSERT_TRUE(set);
  EXPECT_EQ(DepthOfZero(*set).lower, 0);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_TRUE(Balances(*set, Wrench::Unit(axis))) << "force of one weight along " << axis;
    EXPECT_FALSE(Balances(*set, 0.01 * Wrench::Unit(3 + axis))) << "torque about " << axis;
  }

  std::vector<GraspCandidate> candidates(3);
  candidates[0].X_OG = kAroundOrigin;
  for (GraspCandidate& candidate : candidates) candidate.epsilon = candidate.robust = 0.5;
  candidates[1].width_m = 1;          // wider than the stroke
  candidates[2].width_m = kNoNumber;  // these two have no opening
  JudgeJawGrasps(*box, hand, 0.003, surface, options, 1, candidates);
  EXPECT_EQ(candidates[0].epsilon, 0);
  EXPECT_EQ(candidates[0].robust, 0) << "errors of the center of mass exert a torque";
  for (const int unchanged : {1, 2}) {
    EXPECT_EQ(candidates[unchanged].epsilon, 0.5);
    EXPECT_EQ(candidates[unchanged].robust, 0.5);
  }
  std::vector<GraspCandidate> none;
  SetJawEpsilon(*box, hand, 0.003, surface, options, none);
  EXPECT_TRUE(none.empty());
}

TEST(DegenerateContacts, SpreadPointsAreOnTheMesh) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    Rng rng(1);
    if (!test.has_area) {
      EXPECT_THAT(ErrorOf([&] { SpreadPoints(test.mesh, 0.01, 100, 200, rng); }),
                  testing::HasSubstr("a mesh without area"))
          << test.name;
      continue;
    }
    const SurfacePoints surface = SpreadPoints(test.mesh, 0.01, 100, 200, rng);
    EXPECT_TRUE(surface.points_O.rows() >= 100 && surface.points_O.rows() <= 200) << test.name;
    const double area_m2 = SurfaceArea(test.mesh);
    EXPECT_NEAR(surface.area_m2 * static_cast<double>(surface.points_O.rows()), area_m2,
                1e-9 * area_m2)
        << test.name;
    const Bounds bounds = MeshBounds(test.mesh);
    const double rounding_m = 1e-6 * (bounds.min.norm() + bounds.max.norm());
    for (int i = 0; i < surface.points_O.rows(); ++i) {
      const Vector3d p = surface.points_O.row(i).matrix().transpose().cast<double>();
      ASSERT_TRUE((p - bounds.min).minCoeff() >= -rounding_m) << test.name;
      ASSERT_TRUE((bounds.max - p).minCoeff() >= -rounding_m) << test.name;
      ASSERT_NEAR(surface.normals_O.row(i).matrix().norm(), 1, 1e-5) << test.name;
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
