#include "grasp/candidates/wrench_space.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

const WrenchDepthOptions kExact{.tolerance = 1e-9};

WrenchSet Hull(const Wrenches& points) { return {{points}, Wrench::Zero()}; }

// The polytope is refined until both bounds are equal.
double Depth(const WrenchSet& set) {
  const WrenchDepth depth = DepthOfZero(set, kExact);
  EXPECT_NEAR(depth.lower, depth.upper, 1e-6 * std::max(1.0, depth.upper));
  return depth.upper;
}

Matrix6 RandomRotation(Rng& rng) {
  Matrix6 numbers;
  for (int i = 0; i < 36; ++i) numbers.data()[i] = rng.Normal();
  return numbers.householderQr().householderQ();
}

Wrenches Cube() {
  Wrenches corners(6, 64);
  for (int i = 0; i < 64; ++i) {
    for (int k = 0; k < 6; ++k) corners(k, i) = i >> k & 1 ? 1 : -1;
  }
  return corners;
}

Wrenches CrossPolytope() {
  Wrenches corners(6, 12);
  corners << Matrix6::Identity(), -Matrix6::Identity();
  return corners;
}

// Seven points at distance 1 from their center and at equal distances from each other: the unit
// vectors of seven dimensions, projected along (1, ..., 1).
Wrenches RegularSimplex() {
  const Eigen::Matrix<double, 7, 7> square_to_ones =
      Eigen::Matrix<double, 7, 1>::Ones().householderQr().householderQ();
  Wrenches corners = square_to_ones.rightCols<6>().transpose();
  corners.colwise().normalize();
  return corners;
}

TEST(WrenchSpace, DepthOfRegularBodiesIsTheirInradius) {
  struct Case {
    const char* name;
    Wrenches points;
    double inradius;
  };
  const std::vector<Case> cases{{"cube", Cube(), 1},
                                {"cross polytope", CrossPolytope(), 1 / std::sqrt(6.0)},
                                {"simplex", RegularSimplex(), 1.0 / 6}};
  Rng rng(1);
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    EXPECT_NEAR(Depth(Hull(c.points)), c.inradius, 1e-6);
    for (int rotation = 0; rotation < 5; ++rotation) {
      EXPECT_NEAR(Depth(Hull(RandomRotation(rng) * c.points)), c.inradius, 1e-6);
    }
  }
}

TEST(WrenchSpace, DepthIsMeasuredFromZeroAndGrowsWithTheSet) {
  WrenchSet set{{0.5 * Cube(), 0.5 * Cube()}, Wrench::Zero()};  // their sum is the cube
  EXPECT_NEAR(Depth(set), 1, 1e-6);
  set.offset[4] = 0.3;
  EXPECT_NEAR(Depth(set), 0.7, 1e-6);
  set.offset[4] = 1.001;
  EXPECT_EQ(DepthOfZero(set, kExact).upper, 0);
}

TEST(WrenchSpace, SummedRegionsEqualTheHullOfAllSums) {
  Rng rng(3);
  for (int run = 0; run < 5; ++run) {
    Wrenches a(6, 12), b(6, 9);
    for (int i = 0; i < a.size(); ++i) a.data()[i] = rng.Normal();
    for (int i = 0; i < b.size(); ++i) b.data()[i] = rng.Normal();
    a.col(0).setZero();
    b.col(0).setZero();
    Wrenches sums(6, a.cols() * b.cols());
    for (int i = 0; i < sums.cols(); ++i) sums.col(i) = a.col(i % 12) + b.col(i / 12);
    EXPECT_NEAR(Depth({{a, b}, Wrench::Zero()}), Depth(Hull(sums)), 1e-6);
  }
}

// Independent upper bound: from many start directions, the support is minimized. No direction has a
// support below the depth, and the smallest is near it.
TEST(WrenchSpace, NoSupportIsSmallerThanTheDepth) {
  Rng rng(4);
  for (int run = 0; run < 4; ++run) {
    Wrenches points(6, 60);
    for (int i = 0; i < points.size(); ++i) points.data()[i] = rng.Normal();
    const WrenchSet set = Hull(points);
    const double depth = Depth(set);
    double smallest = 1e9;
    for (int start = 0; start < 300; ++start) {
      Wrench direction;
      for (int k = 0; k < 6; ++k) direction[k] = rng.Normal();
      direction.normalize();
      double step = 0.3;
      for (int i = 0; i < 300; ++i, step *= 0.97) {
        const Wrench support = set.Support(direction);
        smallest = std::min(smallest, direction.dot(support));
        direction = (direction - step * support.normalized()).normalized();
      }
    }
    EXPECT_GE(smallest, depth - 1e-7);
    EXPECT_LE(smallest, 1.02 * depth + 1e-7);
  }
}

// Two opposite soft fingers, one radius from the center. The worst load is a mix of sliding,
// rotation about the line between them, and pull along it. With sigma = friction * cos(pi / edges)
// and weak torsion gamma, the depth is 2 / sqrt(1 + 1/sigma^2 + 1/gamma^2). With strong torsion
// only one finger slides, and the depth is 2 / sqrt(4 + 2/sigma^2).
WrenchSet SoftFingers(double friction, double torsion, int edges) {
  WrenchSet set;
  for (const double side : {-1.0, 1.0}) {
    const ContactCone cone{side * Vector3d::UnitX(), -side * Vector3d::UnitX(), 1, friction};
    Wrenches region(6, edges + 2);
    region.leftCols(edges) = ConeEdges(cone, edges, 1);
    for (const int rotation : {0, 1}) {
      region.col(edges + rotation) << cone.inward,
          (rotation ? torsion : -torsion) * Vector3d::UnitX();
    }
    set.regions.push_back(region);
  }
  return set;
}

TEST(WrenchSpace, TwoSoftFingersMatchTheFormula) {
  const int edges = 8;
  const double friction = 0.5, sigma = friction * std::cos(std::numbers::pi / edges);
  const double weak = 0.3;
  EXPECT_NEAR(Depth(SoftFingers(friction, weak, edges)),
              2 / std::sqrt(1 + 1 / (sigma * sigma) + 1 / (weak * weak)), 1e-6);
  EXPECT_NEAR(Depth(SoftFingers(friction, 10, edges)), 2 / std::sqrt(4 + 2 / (sigma * sigma)),
              1e-6);
}

TEST(WrenchSpace, TwoHardPointsResistNoRotationAboutTheirLine) {
  EXPECT_EQ(Depth(SoftFingers(0.5, 0, 8)), 0);
}

TEST(WrenchSpace, ConeEdgesAreOnTheCone) {
  const ContactCone cone{{0.02, 0.01, -0.03}, Vector3d(1, 2, -2).normalized(), 3, 0.7};
  const Wrenches edges = ConeEdges(cone, 6, 0.05);
  for (int k = 0; k < edges.cols(); ++k) {
    const Vector3d force = edges.col(k).head<3>(), torque = edges.col(k).tail<3>();
    EXPECT_NEAR(force.dot(cone.inward), 3, 1e-12);
    EXPECT_NEAR((force - 3 * cone.inward).norm(), 3 * 0.7, 1e-12);
    EXPECT_TRUE(torque.isApprox(cone.point.cross(force) / 0.05));
  }
}

// Coulomb friction: two pads with force F each hold m * a along the pads up to 2 * mu * F.
TEST(WrenchSpace, PadsBalanceLoadsUpToTheFrictionLimit) {
  const double friction = 0.5;
  const WrenchSet set = SoftFingers(friction, 0.3, 8);
  Wrench load = Wrench::Zero();
  load[1] = -0.999 * 2 * friction;  // along an edge of the cone
  EXPECT_TRUE(Balances(set, load));
  load[1] = -1.001 * 2 * friction;
  EXPECT_FALSE(Balances(set, load));
  load = Wrench::Zero();
  load[3] = 0.599;
  EXPECT_TRUE(Balances(set, load));
  load[3] = 0.601;
  EXPECT_FALSE(Balances(set, load));
}

// Every load smaller than the depth is balanced. A cube balances exactly the loads inside it.
TEST(WrenchSpace, LoadsInsideTheDepthAreBalanced) {
  Rng rng(6);
  const WrenchSet set = SoftFingers(0.6, 0.4, 8);
  const double depth = Depth(set);
  for (int i = 0; i < 300; ++i) {
    Wrench load;
    for (int k = 0; k < 6; ++k) load[k] = rng.Normal();
    EXPECT_TRUE(Balances(set, 0.999 * depth * load.normalized()));
  }
  WrenchSet cube = Hull(Cube());
  const Matrix6 rotation = RandomRotation(rng);
  cube.regions[0] = rotation * cube.regions[0];
  for (int i = 0; i < 300; ++i) {
    Wrench load;
    for (int k = 0; k < 6; ++k) load[k] = rng.Uniform(-1.2, 1.2);
    EXPECT_EQ(Balances(cube, rotation * load), load.cwiseAbs().maxCoeff() <= 1);
  }
}

}  // namespace
}  // namespace pickbed::tests
