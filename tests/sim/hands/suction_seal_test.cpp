#include "sim/hands/suction_seal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// Returns the pose of a cup at p that points down, tilted by `tilt_rad` about x.
Pose CupOver(const Eigen::Vector3d& p, double tilt_rad = 0) {
  const Eigen::Matrix3d down = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return MakePose(
      Eigen::Matrix3d(Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitX()).matrix() * down), p);
}

MeshQuery Plate() { return MeshQuery(BoxMesh({{0, 0, -0.01}, {0.05, 0.05, 0.01}})); }

// Returns a closed ring about z from the bore radius (0 = none) to the outer radius, z from -height
// to 0.
TriangleMesh Ring(double bore_m, double outer_m, double height_m) {
  constexpr int kSides = 96;
  TriangleMesh mesh;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    for (const auto& [r, z] : {std::pair(bore_m, 0.0), std::pair(outer_m, 0.0),
                               std::pair(outer_m, -height_m), std::pair(bore_m, -height_m)}) {
      mesh.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  }
  for (int i = 0; i < kSides; ++i) {
    const int a = 4 * i, b = 4 * ((i + 1) % kSides);
    for (int k = 0; k < 4; ++k) {
      const int n = (k + 1) % 4;
      mesh.triangles.emplace_back(a + k, a + n, b + k);
      mesh.triangles.emplace_back(a + n, b + n, b + k);
    }
  }
  return mesh;
}

TEST(CupSeal, PlaneSealsWithinTheBellowsTravel) {
  const MeshQuery plate = Plate();
  const CupSpec spec;
  const CupSeal seal = TestSeal(plate, CupOver({0, 0, -0.003}), spec);
  EXPECT_EQ(seal.fault, SealFault::kNone);
  EXPECT_NEAR(seal.compression_m, 0.003, 1e-9);
  EXPECT_NEAR(seal.uneven_m, 0, 1e-9);
  EXPECT_EQ(TestSeal(plate, CupOver({0, 0, 0.001}), spec).fault, SealFault::kMissed);
  EXPECT_FALSE(TestSeal(plate, CupOver({0, 0, -0.009}), spec).sealed());
}

TEST(CupSeal, DoesNotSealAcrossAnEdge) {
  const MeshQuery plate = Plate();
  EXPECT_TRUE(TestSeal(plate, CupOver({0.034, 0, -0.003}), {}).sealed());
  const CupSeal across = TestSeal(plate, CupOver({0.037, 0, -0.003}), {});
  EXPECT_EQ(across.fault, SealFault::kMissed);
  EXPECT_LT(across.touching, 1);
  EXPECT_GT(across.touching, 0.5);
}

// With a tilt t, the near side of the rim is r sin t nearer and the far side r sin t farther. The
// travel compensates a tilt with tan t <= half the travel / radius.
TEST(CupSeal, BellowsCompensatesATilt) {
  const MeshQuery plate = Plate();
  CupSpec spec;
  const double limit_rad = std::atan(0.5 * spec.bellows_travel_m / spec.radius_m);
  const double center_m = 0.5 * spec.bellows_travel_m;
  for (const double share : {0.5, 0.95, 1.15}) {
    const Pose X_WG = CupOver({0, 0, 0}, share * limit_rad) * Translation({0, 0, center_m});
    const CupSeal seal = TestSeal(plate, X_WG, spec);
    EXPECT_EQ(seal.sealed(), share < 1) << share;
    if (share < 1) {
      EXPECT_NEAR(seal.tilt_rad, share * limit_rad, 1e-6);
      EXPECT_NEAR(seal.uneven_m, 0, 1e-9);
    }
  }
}

// On a cylinder of radius R the height of a rim of radius r varies by the sagitta R - sqrt(R^2 -
// r^2), half of it on each side of the plane.
TEST(CupSeal, CurvatureIsMeasuredByItsSagitta) {
  constexpr double kRadius_m = 0.015;
  TriangleMesh bar = Ring(0, kRadius_m, 0.2);
  const Pose lying = MakePose(
      Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()).matrix(), {0.1, 0, 0});
  for (Eigen::Vector3d& p : bar.vertices) p = lying * p;
  const MeshQuery query(bar);
  for (const double r : {0.006, 0.010}) {
    CupSpec spec;
    spec.radius_m = r;
    const double sagitta_m = kRadius_m - std::sqrt(kRadius_m * kRadius_m - r * r);
    const CupSeal seal = TestSeal(query, CupOver({0, 0, kRadius_m - sagitta_m}), spec);
    EXPECT_NEAR(seal.uneven_m, 0.5 * sagitta_m, 0.15e-3) << r;
    EXPECT_EQ(seal.fault, r < 0.008 ? SealFault::kNone : SealFault::kUneven) << r;
  }
}

TEST(CupSeal, ThroughHoleLeaksAndBlindHoleDoesNot) {
  const MeshQuery ring(Ring(0.006, 0.04, 0.012));
  EXPECT_EQ(TestSeal(ring, CupOver({0, 0, -0.003}), {}).fault, SealFault::kLeaks);
  EXPECT_TRUE(TestSeal(ring, CupOver({0.023, 0, -0.003}), {}).sealed());
  TriangleMesh closed = Ring(0.006, 0.04, 0.012);
  Append(BoxMesh({{0, 0, -0.015}, {0.03, 0.03, 0.003}}), closed);
  EXPECT_TRUE(TestSeal(MeshQuery(closed), CupOver({0, 0, -0.003}), {}).sealed());
}

TEST(CupSeal, StepUnderTheLipIsUneven) {
  TriangleMesh stair = BoxMesh({{-0.05, 0, -0.01}, {0.05, 0.05, 0.01}});
  Append(BoxMesh({{0.05, 0, -0.012}, {0.05, 0.05, 0.01}}), stair);
  EXPECT_TRUE(TestSeal(MeshQuery(stair), CupOver({-0.02, 0, -0.003}), {}).sealed());
  // A step of 2 mm is at most 1 mm on each side of the plane; a step of 4 mm cannot be sealed.
  TriangleMesh high = BoxMesh({{-0.05, 0, -0.01}, {0.05, 0.05, 0.01}});
  Append(BoxMesh({{0.05, 0, -0.014}, {0.05, 0.05, 0.01}}), high);
  EXPECT_EQ(TestSeal(MeshQuery(high), CupOver({0, 0, -0.005}), {}).fault, SealFault::kUneven);
}

}  // namespace
}  // namespace pickbed::tests
