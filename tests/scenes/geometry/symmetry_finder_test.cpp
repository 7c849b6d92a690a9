#include "scenes/geometry/symmetry_finder.h"

#include <gtest/gtest.h>

#include <numbers>

#include "scenes/base/random.h"
#include "scenes/objects/object_catalog.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

size_t DiscreteCount(const TriangleMesh& mesh) { return FindSymmetries(mesh).discrete_O.size(); }

// Returns a prism along z, or a cylinder if it has many sides.
TriangleMesh Prism(int sides, double radius, double height) {
  TriangleMesh mesh;
  for (const double z : {-height / 2, height / 2}) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int j = (i + 1) % sides;
    mesh.triangles.emplace_back(i, j, sides + j);
    mesh.triangles.emplace_back(i, sides + j, sides + i);
    if (i == 0 || j == 0) continue;
    mesh.triangles.emplace_back(0, j, i);
    mesh.triangles.emplace_back(sides, sides + i, sides + j);
  }
  return mesh;
}

TEST(FindSymmetries, FindsTheOrderOfTheRotationGroup) {
  EXPECT_EQ(DiscreteCount(BoxShape({0.1, 0.07, 0.04})), 3u);  // D2
  EXPECT_EQ(DiscreteCount(BoxShape({0.1, 0.1, 0.04})), 7u);   // D4
  EXPECT_EQ(DiscreteCount(BoxShape({0.1, 0.1, 0.1})), 23u);   // O
  EXPECT_EQ(DiscreteCount(BallShape(0.05, 0)), 23u);          // O (octahedron)
  EXPECT_EQ(DiscreteCount(Prism(3, 0.05, 0.03)), 5u);         // D3
  EXPECT_EQ(DiscreteCount(Prism(7, 0.05, 0.03)), 13u);        // D7
}

TEST(FindSymmetries, FindsOneAxisOfACylinderAndTwoOfABall) {
  const SymmetrySet cylinder = FindSymmetries(Prism(64, 0.03, 0.1));
  ASSERT_EQ(cylinder.continuous_O.size(), 1u);
  EXPECT_GT(std::abs(cylinder.continuous_O[0].axis_O.z()), 0.9999);
  EXPECT_EQ(cylinder.discrete_O.size(), 1u);
  TriangleMesh cone = Prism(64, 0.03, 0.1);
  for (int i = 64; i < 128; ++i) cone.vertices[i].head<2>() *= 0.5;
  EXPECT_EQ(FindSymmetries(cone).continuous_O.size(), 1u);
  EXPECT_TRUE(FindSymmetries(cone).discrete_O.empty());
  EXPECT_EQ(FindSymmetries(BallShape(0.05, 4)).continuous_O.size(), 2u);
}

// A closed cup with several rings, whose surface a dent can push in.
TriangleMesh TurnedCup(double dent_m) {
  constexpr int kSides = 48, kRings = 12;
  TriangleMesh mesh;
  for (int ring = 0; ring < kRings; ++ring) {
    for (int i = 0; i < kSides; ++i) {
      const double angle = 2 * std::numbers::pi * i / kSides;
      const bool is_dented = ring >= 5 && ring <= 6 && i >= 3 && i <= 7;
      const double radius = 0.03 + 0.001 * ring - (is_dented ? dent_m : 0);
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.008 * ring);
    }
  }
  const int bottom = static_cast<int>(mesh.vertices.size()), top = bottom + 1;
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, 0.008 * (kRings - 1));
  for (int i = 0; i < kSides; ++i) {
    const int j = (i + 1) % kSides, last = (kRings - 1) * kSides;
    mesh.triangles.emplace_back(bottom, j, i);
    mesh.triangles.emplace_back(top, last + i, last + j);
    for (int ring = 0; ring + 1 < kRings; ++ring) {
      const int a = ring * kSides, b = a + kSides;
      mesh.triangles.emplace_back(a + i, a + j, b + j);
      mesh.triangles.emplace_back(a + i, b + j, b + i);
    }
  }
  return mesh;
}

TEST(FindSymmetries, SmallDentsDoNotHideABodyOfRevolution) {
  const SymmetrySet dented = FindSymmetries(TurnedCup(0.005));  // 4.6 % of the diameter
  ASSERT_EQ(dented.continuous_O.size(), 1u);
  EXPECT_GT(std::abs(dented.continuous_O[0].axis_O.z()), 0.9999);
  EXPECT_LT(dented.continuous_O[0].offset_O.head<2>().norm(), 0.0005);
  EXPECT_TRUE(FindSymmetries(TurnedCup(0.012)).trivial()) << "11 % of the diameter is a feature";
  TriangleMesh mug = TurnedCup(0);
  Append(BoxShape({0.03, 0.01, 0.05}, {0.05, 0, 0.045}), mug);
  EXPECT_TRUE(FindSymmetries(mug).continuous_O.empty()) << "a handle is no dent";
}

// Their corners deviate by less than a dent, but they repeat.
TEST(FindSymmetries, TeethAndCornersAreNoDents) {
  TriangleMesh gear = Prism(48, 0.05, 0.02);
  for (size_t i = 0; i < gear.vertices.size(); ++i) {
    if (i % 4 < 2) gear.vertices[i].head<2>() *= 0.94;
  }
  EXPECT_TRUE(FindSymmetries(gear).continuous_O.empty());
  EXPECT_EQ(FindSymmetries(gear).discrete_O.size(), 23u);  // D12
  EXPECT_TRUE(FindSymmetries(Prism(8, 0.05, 0.03)).continuous_O.empty());
  TriangleMesh oval = Prism(64, 0.05, 0.1);
  for (Vector3d& v : oval.vertices) v.x() *= 0.92;
  EXPECT_TRUE(FindSymmetries(oval).continuous_O.empty());
}

TEST(FindSymmetries, FindsNoneForAnIrregularBox) {
  TriangleMesh box = BoxShape({0.1, 0.1, 0.1});
  box.vertices[7] += Vector3d(0.02, 0.01, 0.015);
  EXPECT_TRUE(FindSymmetries(box).trivial());
}

// A feature breaks a symmetry only if it is larger than the tolerance.
TEST(FindSymmetries, ToleranceIsRelativeToTheDiameter) {
  TriangleMesh box = BoxShape({0.1, 0.08, 0.06});
  Append(BoxShape({0.03, 0.03, 0.004}, {0.02, 0.01, 0.03}), box);  // 2 mm, 1.4 % of the diameter
  EXPECT_TRUE(FindSymmetries(box, {.tolerance_diameters = 0.01}).trivial());
  EXPECT_EQ(FindSymmetries(box, {.tolerance_diameters = 0.02}).discrete_O.size(), 3u);
}

TEST(FindSymmetries, TransformWithTheMesh) {
  const Pose X_AB = MakePose(
      Eigen::Quaterniond(0.3, 0.5, -0.2, 0.7).normalized().toRotationMatrix(), {0.2, -0.3, 0.1});
  const TriangleMesh moved = Transformed(Prism(64, 0.03, 0.1), X_AB);
  const SymmetrySet found = FindSymmetries(moved);
  ASSERT_EQ(found.continuous_O.size(), 1u);
  const Vector3d axis_A = X_AB.linear().col(2);
  EXPECT_LT(found.continuous_O[0].axis_O.cross(axis_A).norm(), 1e-3);
  const Vector3d off = found.continuous_O[0].offset_O - X_AB.translation();
  EXPECT_LT(off.cross(axis_A).norm(), 1e-4);
}

// A prism whose corners are off by up to 0.4 % of its diameter has the exact group of the prism.
TEST(FindSymmetries, RotationsAreExactFractionsOfATurn) {
  for (const int sides : {3, 4, 6}) {
    SCOPED_TRACE(sides);
    TriangleMesh mesh = Prism(sides, 0.05, 0.04);
    Rng rng(3);
    for (Vector3d& p : mesh.vertices) {
      for (int k = 0; k < 3; ++k) p[k] += rng.Uniform(-4e-4, 4e-4);
    }
    const SymmetrySet found = FindSymmetries(mesh);
    ASSERT_EQ(found.discrete_O.size(), 2u * sides - 1);
    int about_z = 0, flips = 0;
    for (const Pose& S : found.discrete_O) {
      const Eigen::AngleAxisd turn(S.linear());
      EXPECT_LT(S.translation().norm(), 1e-12) << "the axes meet in the origin";
      const bool is_about_z = std::abs(turn.axis().z()) > 1 - 1e-12;
      const double steps = turn.angle() / (2 * std::numbers::pi / sides);
      const double flipped = turn.angle() / std::numbers::pi;
      EXPECT_NEAR(is_about_z ? steps : flipped, std::round(is_about_z ? steps : flipped), 1e-9);
      about_z += is_about_z;
      flips += std::abs(turn.axis().z()) < 1e-12;
    }
    EXPECT_EQ(about_z, sides - 1);
    EXPECT_EQ(flips, sides);
  }
}

// The mesh of a scan has any frame, and its vertices are noisy.
TEST(FindSymmetries, DentsAndNoiseDoNotHideABodyOfRevolutionInAnyFrame) {
  TriangleMesh scan = TurnedCup(0.004);
  Rng rng(5);
  for (Vector3d& p : scan.vertices) {
    for (int k = 0; k < 3; ++k) p[k] += rng.Uniform(-2e-4, 2e-4);
  }
  const Pose X_AB = MakePose(
      Eigen::Quaterniond(0.6, -0.4, 0.3, 0.5).normalized().toRotationMatrix(), {0.1, 0.2, -0.3});
  const SymmetrySet found = FindSymmetries(Transformed(scan, X_AB));
  ASSERT_EQ(found.continuous_O.size(), 1u);
  const Vector3d axis_A = X_AB.linear().col(2);
  EXPECT_LT(found.continuous_O[0].axis_O.cross(axis_A).norm(), 0.02);
  const Vector3d off = found.continuous_O[0].offset_O - X_AB.translation();
  EXPECT_LT(off.cross(axis_A).norm(), 0.001);
}

// The symmetries that the part families declare are found from the meshes.
class ShippedSymmetries : public ::testing::TestWithParam<std::string> {};

TEST_P(ShippedSymmetries, AreFoundFromTheMesh) {
  const auto object = ObjectCatalog({AssetsDir() / "objects"}).Load(GetParam());
  const SymmetrySet found = FindSymmetries(object->mesh_O);
  const SymmetrySet& declared = object->symmetries_O;
  EXPECT_EQ(found.continuous_O.size(), declared.continuous_O.size());
  EXPECT_EQ(found.discrete_O.size(), declared.discrete_O.size());
  for (const Pose& S : declared.continuous_O.empty() ? declared.discrete_O : std::vector<Pose>()) {
    const bool known =
        std::any_of(found.discrete_O.begin(), found.discrete_O.end(), [&](const Pose& other) {
          return RotationAngleRad(S.linear(), other.linear()) < 0.02 &&
                 (S.translation() - other.translation()).norm() < 0.01 * object->diameter_m;
        });
    EXPECT_TRUE(known) << S.matrix();
  }
}
INSTANTIATE_TEST_SUITE_P(All, ShippedSymmetries,
                         ::testing::Values("bottle", "bracket", "carton", "elbow", "flange", "gear",
                                           "hex_bolt", "mug", "pipe_tee", "ring", "rod", "u_clip"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace pickbed::tests
