// Geometry of grasps on degenerate meshes and sets of wrenches.

#include <gtest/gtest.h>

#include <cmath>

#include "grasp/candidates/antipodal.h"
#include "grasp/candidates/suction.h"
#include "grasp/candidates/surface_sampling.h"
#include "grasp/candidates/wrench_space.h"
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
