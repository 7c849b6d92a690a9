// Plans a grasp on estimated poses, executes it in the physics, and prints the outcome.

#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "grasp/plan/plan.h"
#include "scenes/base/files.h"
#include "scenes/camera/depth_points.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/failure_reason.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/resting_poses.h"
#include "sim/render/renderer.h"

using namespace pickbed::scenes;
using namespace pickbed::sim;
using namespace pickbed::grasp;

namespace {

bool PlanAndExecuteGrasp() {
  // Resting directions show the planner on which side an object can be set down.
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  const ObjectSet objects = WithRestingDirections(WithConvexPieces(ObjectSet{catalog.Load("rod")}));
  const Bin bin;
  const Scene scene = MakeScene({bin, objects, {6}, /*seed=*/3, BinIndex(0)}).scene;

  // The poses may come from an estimator, a file or another program. Here they are the true ones.
  std::vector<EstimatedPose> poses;
  for (const PosedObject& posed : scene.objects) {
    poses.push_back({.object = posed.object, .X_WO = posed.X_WO, .confidence = 1});
  }

  // The observed points in W. The hand keeps clear of them.
  const Camera camera({}, LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, Eigen::Vector3d::UnitZ()));
  const RenderedImage image = SceneRenderer(objects, bin).Render(scene, camera);
  std::vector<Eigen::Vector3d> cloud_W;
  ForEachDepthPoint(
      camera.intrinsics, image.depth_m,
      [&](int, int, const Eigen::Vector3d& p_C) { cloud_W.push_back(camera.X_WC() * p_C); },
      /*stride=*/2);

  // Grasps of each object, in its own frame. They are computed once and kept in the cache.
  const std::shared_ptr<const Gripper> gripper = LoadGripper("jaw_8cm");
  std::vector<std::vector<GraspCandidate>> candidates;
  for (const auto& object : objects) candidates.push_back(CachedCandidates(*object, *gripper));

  const PlanResult plan = PlanGrasps({bin, poses, candidates, cloud_W, objects, *gripper});
  if (plan.grasps.empty()) {
    std::printf("no grasp is free\n");
    return false;
  }
  const Grasp& grasp = plan.grasps.front();
  const Eigen::Vector3d p_WG = grasp.X_WG.translation();
  std::printf("grasp: score %.2f at (%.3f, %.3f, %.3f) m, opening %.1f mm\n", grasp.score, p_WG.x(),
              p_WG.y(), p_WG.z(), 1e3 * grasp.width_m);

  // The physics world is rebuilt from `scene`, which does not change.
  const PosedObject& target = scene.objects[grasp.hypothesis];
  const ExecuteResult result =
      ExecuteGrasp(scene, objects, grasp, *gripper, {target.instance, target.object, target.X_WO});
  const GraspOutcome& outcome = result.outcome;
  std::printf("failure: %s\n", std::string(FailureName(outcome.failure)).c_str());
  std::printf("slip: %.2f mm\n", 1e3 * outcome.slip_m);
  std::printf("placed with an error of %.1f mm\n", 1e3 * outcome.place_error_m);
  std::printf("left in the bin: %zu\n", result.after.objects.size());
  return outcome.success;
}

}  // namespace

int main() try { return PlanAndExecuteGrasp() ? 0 : 1; } catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
