// Geometry of grasps on degenerate meshes and sets of wrenches.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "grasp/candidates/antipodal.h"
#include "grasp/candidates/candidates.h"
#include "grasp/candidates/robustness.h"
#include "grasp/candidates/suction.h"
#include "grasp/candidates/surface_sampling.h"
#include "grasp/candidates/wrench_space.h"
#include "grasp/grippers/suction_cup.h"
#include "scenes/base/error.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/scenes/geometry/degenerate_meshes.h"

namespace pickbed::tests {
namespace {

TEST(DegenerateSharpEdges, PointsAreFinite) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const Bounds bounds = MeshBounds(test.mesh);
    const double spacing_m = std::max(1e-9, 0.05 * bounds.size().norm());
    const Eigen::Matrix3Xd points = SharpEdgePoints(test.mesh, spacing_m);
    EXPECT_TRUE(points.allFinite()) << test.name;
    EXPECT_TRUE(test.has_area || points.cols() == 0) << test.name;
  }
}

// An object of such a mesh. Without a volume it gets the mass of a point.
ObjectModel ObjectOf(const DegenerateMesh& test) {
  ObjectModel model;
  model.mesh_O = test.mesh;
  model.mesh_hash = MeshHash(test.mesh);
  model.diameter_m = Diameter(test.mesh);
  model.resting_O = {{}};
  model.mass.mass_kg = 0.1;
  model.mass.inertia_com_O = 1e-6 * Eigen::Matrix3d::Identity();
  if (test.has_volume) model.mass = UniformMassProperties(test.mesh, 0.1);
  return model;
}

void ExpectSound(const std::vector<GraspCandidate>& grasps, const std::string& name) {
  for (const GraspCandidate& grasp : grasps) {
    EXPECT_TRUE(grasp.X_OG.matrix().allFinite()) << name;
    EXPECT_NEAR(grasp.X_OG.linear().determinant(), 1, 1e-6) << name;
    EXPECT_TRUE(grasp.quality >= 0 && grasp.quality <= 1) << name << " " << grasp.quality;
    EXPECT_TRUE(std::isfinite(grasp.width_m) && grasp.width_m >= 0) << name;
  }
}

// A mesh without an area has no candidates or is refused.
TEST(DegenerateCandidates, AreFinite) {
  const ParallelJaw jaw = SmallJaw();
  const AntipodalOptions few_pairs{.candidates = 40, .max_samples = 400, .max_pairs = 20};
  SuctionOptions few_points;
  few_points.max_samples = 100;
  RobustOptions robust;
  robust.samples = 2;
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const ObjectModel model = ObjectOf(test);
    Rng rng(1);
    for (const bool suction : {false, true}) {
      try {
        const std::vector<GraspCandidate> grasps =
            suction ? SuctionGrasps(model, CupSpec{}, rng, few_points, robust)
                    : AntipodalGrasps(model, jaw.hand, jaw.clearance_m, rng, few_pairs);
        ExpectSound(grasps, test.name);
        EXPECT_TRUE(test.has_area || grasps.empty()) << test.name;
      } catch (const InputError& error) {
        EXPECT_FALSE(test.has_area) << test.name << ": " << error.what();
      }
    }
  }
}

// All quality measures, also the ones that a hand and a resting direction give.
TEST(DegenerateCandidates, QualitiesAreShares) {
  GraspCandidateOptions options;
  options.antipodal.max_samples = 400;
  options.antipodal.max_pairs = 20;
  options.suction.max_samples = 60;
  options.robust.samples = 2;
  const ParallelJaw jaw = SmallJaw();
  const SuctionCup cup;
  size_t found = 0;
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (!test.has_area) continue;
    for (const Gripper* gripper :
         {static_cast<const Gripper*>(&jaw), static_cast<const Gripper*>(&cup)}) {
      Rng rng(1);
      const auto grasps = MakeCandidates(ObjectOf(test), *gripper, rng, options);
      ExpectSound(grasps, test.name);
      for (const GraspCandidate& grasp : grasps) {
        EXPECT_TRUE(grasp.place_quality >= 0 && grasp.place_quality <= 1) << test.name;
        EXPECT_TRUE(grasp.robust >= 0 && grasp.robust <= 1) << test.name;
        EXPECT_TRUE(std::isfinite(grasp.epsilon) && grasp.epsilon >= 0) << test.name;
      }
      found += grasps.size();
    }
  }
  EXPECT_GT(found, 0u) << "some mesh must have a grasp to check";
}

TEST(DegenerateCandidates, EqualOnesAreSpreadToOne) {
  const std::vector<GraspCandidate> equal(5);
  const auto count = [](const std::vector<GraspCandidate>& all, int wanted, bool same) {
    return SpreadOverDirections(all, wanted, [&](const auto&, const auto&) { return same; }).size();
  };
  EXPECT_EQ(count({}, 3, true), 0u);
  EXPECT_EQ(count(equal, 0, false), 0u);
  EXPECT_EQ(count(equal, -1, false), 0u);
  EXPECT_EQ(count(equal, 3, true), 1u);
  EXPECT_EQ(count(equal, 3, false), 3u);
  EXPECT_EQ(count(equal, 9, false), 5u);
}

TEST(DegenerateRobustness, OfAPointIsAShare) {
  ObjectModel point;
  point.mass.mass_kg = 0.1;
  EXPECT_EQ(WrenchRadius_m(point), 0);
  const auto never = [](const Pose&, double) { return std::optional<WrenchSet>(); };
  const auto nothing = [](const Pose&, double) { return std::optional<WrenchSet>(WrenchSet()); };
  EXPECT_EQ(RobustShare(point, Pose::Identity(), never, Rng(1), {}), 0);
  EXPECT_EQ(RobustShare(point, Pose::Identity(), nothing, Rng(1), {}), 0);
}

// Without friction, the rim only pushes along the approach.
TEST(DegenerateWrenchSets, ACupWithoutFrictionResistsNoShearAndNoTorsion) {
  const auto box = BoxObject({0.05, 0.05, 0.05}, 0.2);
  const WrenchSet set = CupWrenches(*box, CupSpec(), FromAbove({0, 0, 0.025}), 0, 0, 8);
  EXPECT_EQ(DepthOfZero(set).lower, 0);
  EXPECT_TRUE(Balances(set, -Wrench::Unit(2))) << "the weight";
  EXPECT_FALSE(Balances(set, 0.01 * Wrench::Unit(0)));
  EXPECT_FALSE(Balances(set, 0.01 * Wrench::Unit(5)));
}

TEST(DegenerateWrenchSets, ConesWithoutFrictionOrForceAreLinesAndPoints) {
  const ContactCone cone{{0.01, 0, 0}, Eigen::Vector3d::UnitZ(), 2, 0};
  const Wrenches line = ConeEdges(cone, 5, 0.05);
  ContactCone weak = cone;
  weak.force = 0;
  weak.friction = 1;
  EXPECT_TRUE(ConeEdges(weak, 5, 0.05).isZero());
  for (int k = 0; k < 5; ++k) {
    EXPECT_TRUE(line.col(k).head<3>().isApprox(2 * Eigen::Vector3d::UnitZ()));
    EXPECT_NEAR(line(4, k), -2 * 0.01 / 0.05, 1e-12) << "y of (0.01, 0, 0) x (0, 0, 2)";
  }
}

// Segments along the first axes. All six make a cube.
TEST(DegenerateWrenchSets, OnlyTheSpannedDirectionsAreResisted) {
  WrenchSet set;
  for (int rank = 1; rank <= 6; ++rank) {
    Wrenches segment(6, 3);
    segment << Wrench::Unit(rank - 1), -Wrench::Unit(rank - 1),
        Wrench::Unit(rank - 1);  // one twice
    set.regions.push_back(segment);
    const WrenchDepth depth = DepthOfZero(set);
    EXPECT_NEAR(depth.lower, rank < 6 ? 0 : 1, 1e-3) << rank;
    EXPECT_NEAR(depth.upper, rank < 6 ? 0 : 1, 1e-3) << rank;
    for (int axis = 0; axis < 6; ++axis) {
      EXPECT_EQ(Balances(set, 0.9 * Wrench::Unit(axis)), axis < rank) << rank << " " << axis;
    }
  }
}

TEST(DegenerateWrenchSets, WhatIsNotFiniteIsNotResisted) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), kInfinity}) {
    WrenchSet set;
    set.regions = {value * Wrenches::Identity(6, 6)};
    EXPECT_EQ(DepthOfZero(set).lower, 0) << value;
    set.regions = {Wrenches::Identity(6, 6), -Wrenches::Identity(6, 6)};
    EXPECT_TRUE(Balances(set, 0.1 * Wrench::Unit(0)));
    EXPECT_FALSE(Balances(set, Wrench::Constant(value))) << value;
  }
}

// A set of wrenches without a volume resists nothing, and zero load is always balanced by zero.
TEST(DegenerateWrenchSets, ResistNothing) {
  const Wrench x = Wrench::Unit(0), load = Wrench::Unit(3);
  WrenchSet none, one_point, line;
  one_point.regions = {Wrenches(x)};
  Wrenches both(6, 2);
  both << x, -x;
  line.regions = {both};
  for (const WrenchSet& set : {none, one_point, line}) {
    const WrenchDepth depth = DepthOfZero(set);
    EXPECT_TRUE(std::isfinite(depth.lower) && std::isfinite(depth.upper));
    EXPECT_EQ(depth.lower, 0);
    EXPECT_TRUE(Balances(set, Wrench::Zero()));
    EXPECT_FALSE(Balances(set, load));
    EXPECT_TRUE(set.Support(x).allFinite());
  }
}

}  // namespace
}  // namespace pickbed::tests
