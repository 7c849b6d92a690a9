// Empties bins of 20 instances of one object with true poses, and reports what the plan left and
// why:
//   plan_figures PART|all BINS [KEY=VALUE ...]
// Keys are plan.KEY for PlanOptions, execute.KEY for ExecuteOptions, and gripper.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "grasp/plan/plan.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/resting_poses.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kInstances = 20;
constexpr int kCloudPoints = 3000;  // per instance
constexpr int kMaxFailures = 2;     // in a row, as in the clutter removal protocol

struct Settings {
  std::string gripper = "jaw_8cm";
  PlanOptions plan;
  ExecuteOptions execute;
  void Visit(SettingsVisitor& v) {
    v.Text("gripper", gripper, {}, "name or file");
    v.Group(
        "plan", [this](SettingsVisitor& g) { plan.Visit(g); }, "");
    v.Group(
        "execute", [this](SettingsVisitor& g) { execute.Visit(g); }, "");
  }
};

struct Count {
  int dropped = 0, cleared = 0, attempts = 0, placed = 0, second_attempts = 0,
      successful_second = 0;
  double plan_s = 0;
  int plans = 0;
  std::map<std::string, int> failures, rejected;  // rejections of the plans without any grasp
  std::vector<std::string> misplaced;
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Returns the surface samples of all instances that face up, in W, without occlusion.
std::vector<Eigen::Vector3d> CloudOf(const Scene& scene, const ObjectModel& model) {
  Rng rng(1);
  const SurfaceSamples samples = SampleSurface(model.mesh_O, kCloudPoints, rng);
  std::vector<Eigen::Vector3d> cloud_W;
  for (const PosedObject& posed : scene.objects) {
    for (size_t i = 0; i < samples.points.size(); ++i) {
      const Eigen::Vector3d normal_W = posed.X_WO.linear() * samples.normals[i];
      if (normal_W.z() > 0) cloud_W.push_back(posed.X_WO * samples.points[i]);
    }
  }
  return cloud_W;
}

PlanResult PlanOnce(const Scene& scene, const ObjectSet& objects, const Gripper& gripper,
                    const std::vector<std::vector<GraspCandidate>>& candidates,
                    const Settings& settings, Count& count) {
  std::vector<EstimatedPose> poses;
  for (const PosedObject& posed : scene.objects) poses.push_back({posed.object, posed.X_WO, 1});
  const auto cloud_W = CloudOf(scene, *objects[0]);
  const double begin_s = CpuSeconds();
  PlanResult plan =
      PlanGrasps({scene.bin, poses, candidates, cloud_W, objects, gripper}, settings.plan);
  count.plan_s += CpuSeconds() - begin_s;
  ++count.plans;
  count.second_attempts += plan.with_relaxed_constraints;
  return plan;
}

// Describes the final pose relative to the planned one, and the release.
std::string HowPlaced(const Bin& bin, const ObjectModel& model, const Pose& X_WO,
                      const Grasp& grasp, const Gripper& gripper, const PlaceOptions& options,
                      const GraspOutcome& outcome) {
  const double opening_m = gripper.ApproachOpening_m(grasp.width_m).value_or(0);
  const PlacePlan plan = PlanPlace(bin, model, X_WO, grasp.X_WG, gripper.Boxes(opening_m), options);
  const Pose X_WO_release = plan.X_WG * grasp.X_WG.inverse() * X_WO;
  double drop_m = 1;
  for (const Eigen::Vector3d& p_O : model.mesh_O.vertices) {
    drop_m = std::min(drop_m, (X_WO_release * p_O).z());
  }
  return fmt::format(
      "{:.0f}mm/{:.0f}deg(in hand {:.0f}mm/{:.0f}deg, dropped {:.0f}mm, inclined "
      "{:.0f}, hand {:.0f})",
      1e3 * outcome.place_error_m, 57.3 * outcome.place_rotation_error_rad, 1e3 * outcome.slip_m,
      57.3 * outcome.in_hand_rotation_error_rad, 1e3 * drop_m,
      57.3 * RotationAngleRad(X_WO_release.linear(), plan.X_WO.linear()),
      57.3 * std::acos(-plan.X_WG.linear()(2, 2)));
}

void Empty(Scene scene, const ObjectSet& objects, const Gripper& gripper,
           const std::vector<std::vector<GraspCandidate>>& candidates, const Settings& settings,
           Count& count) {
  count.dropped += static_cast<int>(scene.objects.size());
  for (int failures = 0; failures < kMaxFailures && !scene.objects.empty();) {
    const PlanResult plan = PlanOnce(scene, objects, gripper, candidates, settings, count);
    if (plan.grasps.empty()) {
      for (const auto& [cause, grasps] : plan.rejected) count.rejected[cause] += grasps;
      return;
    }
    const Grasp& grasp = plan.grasps[std::min<size_t>(failures, plan.grasps.size() - 1)];
    const PosedObject target = scene.objects[grasp.hypothesis];
    ExecuteResult result =
        ExecuteGrasp(scene, objects, grasp, gripper, {target.instance, target.object, target.X_WO},
                     settings.execute);
    const GraspOutcome& outcome = result.outcome;
    ++count.attempts;
    failures = outcome.success ? 0 : failures + 1;
    count.cleared += outcome.success;
    count.successful_second += outcome.success && plan.with_relaxed_constraints;
    if (!outcome.success) ++count.failures[std::string(FailureName(outcome.failure))];
    const bool placed = outcome.verdicts[static_cast<int>(SuccessRule::kPlaced)];
    count.placed += placed;
    if (outcome.success && !placed) {
      count.misplaced.push_back(HowPlaced(scene.bin, *objects[0], target.X_WO, grasp, gripper,
                                          settings.execute.place, outcome));
    }
    scene = std::move(result.after);
  }
}

void Measure(const std::string& name, int bins, const Settings& settings) {
  const ObjectSet objects = WithRestingDirections(
      WithConvexPieces(ObjectSet{ObjectCatalog({AssetsDir() / "objects"}).Load(name)}));
  const auto loaded = LoadGripper(settings.gripper);
  const Gripper& gripper = *loaded;
  Bin bin;  // scaled to the object, as in the presets bin_PART
  bin.inner_size_m = Eigen::Vector3d(4, 3, 1.5) * objects[0]->diameter_m;
  const std::vector<std::vector<GraspCandidate>> candidates{CachedCandidates(*objects[0], gripper)};
  Count count;
  for (int trial = 0; trial < bins; ++trial) {
    const CertifiedScene made = MakeScene({bin, objects, {kInstances}, 0, BinIndex(trial)});
    Empty(made.scene, objects, gripper, candidates, settings, count);
  }
  fmt::print(
      "{:<9} {} grasps; cleared {}/{}, success {}/{}, placed {}; plan {:.0f} ms; second attempts "
      "{}, successful {};",
      name, candidates[0].size(), count.cleared, count.dropped, count.cleared, count.attempts,
      count.placed, 1e3 * count.plan_s / std::max(1, count.plans), count.second_attempts,
      count.successful_second);
  for (const auto& [failure, n] : count.failures) fmt::print(" {} {}", failure, n);
  for (const std::string& text : count.misplaced) fmt::print(" {}", text);
  fmt::print("\n   remaining because of");
  for (const auto& [cause, n] : count.rejected) fmt::print(" {} {},", cause, n);
  fmt::print("\n");
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  const std::string wanted = argc > 2 ? argv[1] : "";
  const int bins = argc > 2 ? std::atoi(argv[2]) : 0;
  if (bins < 1) {
    fmt::print(stderr, "plan_figures PART|all BINS [KEY=VALUE ...]\n");
    return 1;
  }
  Settings settings;
  for (int i = 3; i < argc; ++i) {
    ApplySetting(argv[i], [&](SettingsVisitor& v) { settings.Visit(v); });
  }
  const auto names = ObjectCatalog({AssetsDir() / "objects"}).Names();
  for (const std::string& name : names) {
    if (wanted == "all" || wanted.find(name) != std::string::npos) Measure(name, bins, settings);
  }
  return 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) { return pickbed::tests::Main(argc, argv); }
