#include "scenes/geometry/mass_properties.h"

#include <gmock/gmock.h>

#include <numbers>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d BoxInertia(double mass, const Vector3d& size) {
  const Vector3d squares = size.cwiseAbs2();
  return mass / 12 * (squares.sum() * Matrix3d::Identity() - Matrix3d(squares.asDiagonal()));
}

TEST(UniformMassProperties, MatchTheBoxFormulaAtAnyPosition) {
  const Vector3d size(0.1, 0.2, 0.3);
  for (const Vector3d& center : {Vector3d(0, 0, 0), Vector3d(0.5, -1, 2), Vector3d(100, 0, 0)}) {
    const MassProperties p = UniformMassProperties(BoxShape(size, center), 2.0);
    EXPECT_NEAR(p.volume_m3, 0.006, 1e-12);
    EXPECT_EQ(p.mass_kg, 2.0);
    EXPECT_LT((p.com_O - center).norm(), 1e-12);
    EXPECT_LT((p.inertia_com_O - BoxInertia(2, size)).norm(), 1e-10);
  }
}

TEST(UniformMassProperties, RotateWithTheMesh) {
  Rng rng(1);
  const Pose X_AB = MakePose(rng.Rotation().toRotationMatrix(), {0.3, 0.2, 0.1});
  const TriangleMesh box = BoxShape({0.1, 0.2, 0.3}, {0.1, 0, 0});
  const MassProperties p = UniformMassProperties(Transformed(box, X_AB), 1.0);
  EXPECT_LT((p.com_O - X_AB * Vector3d(0.1, 0, 0)).norm(), 1e-12);
  const Matrix3d rotated =
      X_AB.linear() * BoxInertia(1, {0.1, 0.2, 0.3}) * X_AB.linear().transpose();
  EXPECT_LT((p.inertia_com_O - rotated).norm(), 1e-12);
}

TEST(UniformMassProperties, MatchTheTetrahedronFormula) {
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties p = UniformMassProperties(tetrahedron, 1.0);
  EXPECT_NEAR(p.volume_m3, 1.0 / 6, 1e-15);
  EXPECT_LT((p.com_O - Vector3d::Constant(0.25)).norm(), 1e-14);
  // Inertia about the corner for mass 1: moments 1/5, products -1/20. The center of mass is at 1/4.
  EXPECT_NEAR(p.inertia_com_O(0, 0), 1.0 / 5 - 2.0 / 16, 1e-14);
  EXPECT_NEAR(p.inertia_com_O(0, 1), -1.0 / 20 + 1.0 / 16, 1e-14);
}

TEST(UniformMassProperties, ApproachTheBallFormula) {
  const MassProperties p = UniformMassProperties(BallShape(0.5, 6), 3.0);
  EXPECT_NEAR(p.volume_m3, 4.0 / 3 * std::numbers::pi * 0.125, 1e-3);
  EXPECT_LT((p.inertia_com_O - 0.4 * 3 * 0.25 * Matrix3d::Identity()).norm(), 1e-3);
}

// Mass and inertia of two touching bodies are the sums of both.
TEST(UniformMassProperties, AreAdditive) {
  const TriangleMesh upright = BoxShape({0.02, 0.05, 0.10}, {0.01, 0, 0.05});
  const TriangleMesh foot = BoxShape({0.06, 0.05, 0.02}, {0.05, 0, 0.01});
  TriangleMesh both = upright;
  Append(foot, both);
  const double density = 2700;
  const MassProperties a = UniformDensityProperties(upright, density);
  const MassProperties b = UniformDensityProperties(foot, density);
  const MassProperties sum = UniformDensityProperties(both, density);
  EXPECT_NEAR(sum.mass_kg, a.mass_kg + b.mass_kg, 1e-12);
  const Vector3d com = (a.mass_kg * a.com_O + b.mass_kg * b.com_O) / sum.mass_kg;
  EXPECT_LT((sum.com_O - com).norm(), 1e-12);
  Matrix3d inertia = Matrix3d::Zero();
  for (const MassProperties& body : {a, b}) {  // the parallel axis theorem
    const Vector3d d = body.com_O - com;
    inertia += body.inertia_com_O +
               body.mass_kg * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
  }
  EXPECT_LT((sum.inertia_com_O - inertia).norm(), 1e-12);
}

TEST(UniformMassProperties, SubtractACavity) {
  TriangleMesh hollow = BoxShape({0.2, 0.2, 0.2}), cavity = BoxShape({0.1, 0.1, 0.1});
  TurnInsideOut(cavity);
  Append(cavity, hollow);
  const MassProperties p = UniformDensityProperties(hollow, 1000);
  EXPECT_NEAR(p.mass_kg, 7, 1e-12);
  const Matrix3d inertia =
      BoxInertia(8, Vector3d::Constant(0.2)) - BoxInertia(1, Vector3d::Constant(0.1));
  EXPECT_LT((p.inertia_com_O - inertia).norm(), 1e-12);
}

TEST(UniformMassProperties, RefuseMeshesWithoutPositiveVolume) {
  TriangleMesh inside_out = BoxShape({1, 1, 1});
  TurnInsideOut(inside_out);
  EXPECT_THAT(InputErrorOf([&] { UniformMassProperties(inside_out, 1); }),
              testing::HasSubstr("no positive volume"));
  InputErrorOf([] { UniformMassProperties(BoxShape({1, 1, 0}), 1); });
  InputErrorOf([] { UniformMassProperties({}, 1); });
  for (const double mass : {0.0, -1.0, std::nan("")}) {
    InputErrorOf([&] { UniformMassProperties(BoxShape({1, 1, 1}), mass); });
    InputErrorOf([&] { UniformDensityProperties(BoxShape({1, 1, 1}), mass); });
  }
  EXPECT_NO_THROW(UniformMassProperties(BoxShape({0.3, 0.2, 1e-4}), 0.01));  // a sheet
}

}  // namespace
}  // namespace pickbed::tests
