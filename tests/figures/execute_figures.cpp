// Long measurements of grasps in full bins, printed to stdout:
//   execute_figures speed ATTEMPTS      CPU seconds from approach to shake, ATTEMPTS per object
//   execute_figures agreement ATTEMPTS  verdicts of planned grasps, compared with slower and finer
//                                       physics
//   execute_figures fickle ATTEMPTS     the same with pose errors, which make many
//                                       verdicts uncertain
//   execute_figures labels GRASPS       labels of two runs over the same grasps
// A bin holds the picked instance and 20 neighbors of the same object. The given poses are the true
// ones.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "grasp/candidates/candidates.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/table.h"
#include "grasp/plan/plan.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kInstances = 21;
constexpr int kEachScene = 7;        // maximum attempts per bin, each on another instance
constexpr int kGraspsPlanned = 300;  // enough to find this many reachable instances
constexpr double kShift_m = 1e-4;    // shift of the gripper, to measure how uncertain verdicts are

// Sigmas of an error that is added to grasps, like the error of an estimated pose.
struct GraspError {
  double error_m = 0;
  double error_rad = 0;
};

// Grasps planned with true poses nearly all succeed; with these errors about half do.
constexpr GraspError kFickle{0.004, 0.08};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A scene with a grasp that was planned with true poses.
struct Case {
  Scene scene;
  Grasp grasp;
  InstanceId target = kNoInstance;
};

struct ObjectCases {
  std::string name;
  ObjectSet objects;
  std::vector<Case> cases;
};

// Returns the surface samples of all instances that face up, in W.
std::vector<Eigen::Vector3d> CloudOf(const Scene& scene, const ObjectModel& model) {
  Rng rng(1);
  const SurfaceSamples samples = SampleSurface(model.mesh_O, 3000, rng);
  std::vector<Eigen::Vector3d> cloud_W;
  for (const PosedObject& posed : scene.objects) {
    for (size_t i = 0; i < samples.points.size(); ++i) {
      const Eigen::Vector3d normal_W = posed.X_WO.linear() * samples.normals[i];
      if (normal_W.z() > 0) cloud_W.push_back(posed.X_WO * samples.points[i]);
    }
  }
  return cloud_W;
}

// Returns one grasp per reachable instance, drawn at random from the planned ones, because the best
// grasps would hardly ever fail.
std::vector<Case> CasesOf(const Scene& scene, const ObjectSet& objects,
                          const std::vector<GraspCandidate>& candidates, const Gripper& gripper,
                          Rng& rng) {
  std::vector<EstimatedPose> poses;
  for (const PosedObject& posed : scene.objects) poses.push_back({posed.object, posed.X_WO, 1});
  PlanOptions options;
  options.max_grasps = kGraspsPlanned;
  const std::vector<std::vector<GraspCandidate>> all{candidates};
  const auto cloud_W = CloudOf(scene, *objects[0]);
  const PlanResult plan = PlanGrasps({scene.bin, poses, all, cloud_W, objects, gripper}, options);
  std::map<int, std::vector<Grasp>> by_instance;
  for (const Grasp& grasp : plan.grasps) by_instance[grasp.hypothesis].push_back(grasp);
  std::vector<Case> cases;
  for (const auto& [instance, grasps] : by_instance) {
    const Grasp& grasp = grasps[rng.Index(static_cast<int>(grasps.size()))];
    if (static_cast<int>(cases.size()) == kEachScene) break;
    cases.push_back({scene, grasp, scene.objects[instance].instance});
  }
  return cases;
}

ObjectCases MakeCases(const std::string& name, const Gripper& gripper, int attempts) {
  ObjectCases group{
      name, WithConvexPieces(ObjectSet{ObjectCatalog({AssetsDir() / "objects"}).Load(name)}), {}};
  Bin bin;  // scaled to the object, as in the presets bin_PART
  bin.inner_size_m = Eigen::Vector3d(4, 3, 1.5) * group.objects[0]->diameter_m;
  const auto candidates = CachedCandidates(*group.objects[0], gripper);
  for (uint64_t trial = 0; static_cast<int>(group.cases.size()) < attempts; ++trial) {
    Rng rng = Rng::Derive(0, trial, "grasps");
    const CertifiedScene made = MakeScene({bin, group.objects, {kInstances}, 0, BinIndex(trial)});
    for (Case& found : CasesOf(made.scene, group.objects, candidates, gripper, rng)) {
      if (static_cast<int>(group.cases.size()) < attempts) group.cases.push_back(std::move(found));
    }
    if (trial > static_cast<uint64_t>(attempts)) break;  // an object that is hardly ever reachable
  }
  return group;
}

std::vector<ObjectCases> AllCases(const Gripper& gripper, int attempts_each) {
  std::vector<ObjectCases> all;
  for (const std::string& name : ObjectCatalog({AssetsDir() / "objects"}).Names()) {
    all.push_back(MakeCases(name, gripper, attempts_each));
  }
  return all;
}

int AttemptsPerObject(int attempts) {
  const int object_count =
      static_cast<int>(ObjectCatalog({AssetsDir() / "objects"}).Names().size());
  return (attempts + object_count - 1) / object_count;
}

void MeasureSpeed(int attempts) {
  const auto loaded = LoadGripper("jaw_8cm");
  const Gripper& gripper = *loaded;
  ExecuteOptions options;
  options.carry = false;
  double mean_of_means_s = 0;
  const auto groups = AllCases(gripper, attempts);
  for (const ObjectCases& group : groups) {
    double sum_s = 0, slowest_s = 0;
    int succeeded = 0;
    for (const Case& one : group.cases) {
      const double begin_s = CpuSeconds();
      const ExecuteResult result =
          ExecuteGrasp(one.scene, group.objects, one.grasp, gripper, one.target, options);
      const double took_s = CpuSeconds() - begin_s;
      sum_s += took_s;
      slowest_s = std::max(slowest_s, took_s);
      succeeded += result.outcome.success;
    }
    const double mean_s = sum_s / static_cast<double>(std::max<size_t>(1, group.cases.size()));
    mean_of_means_s += mean_s / static_cast<double>(groups.size());
    fmt::print("{:<10} {:.3f} CPU s per full attempt, slowest {:.3f}; {} of {} succeeded\n",
               group.name, mean_s, slowest_s, succeeded, group.cases.size());
    std::fflush(stdout);
  }
  fmt::print("speed: {:.4f} CPU s per full attempt, mean of {} objects\n", mean_of_means_s,
             groups.size());
}

// Options for one run of all attempts.
struct Variant {
  std::string name;
  ExecuteOptions options;
  double shift_m = 0;  // shift of the gripper, in a random direction per attempt
  int reference = 0;   // index of the variant with which the verdicts are compared
};

std::vector<Variant> Variants() {
  Variant default_variant{"usual", {}, 0};
  Variant shifted{"gripper shifted by 0.1 mm", {}, kShift_m};
  Variant plain{"no shortcut in a step", {}, 0};
  plain.options.physics = PhysicsOptions();
  Variant active = plain;
  active.name = "no shortcut, all bodies active";
  active.options.world.all_active = true;
  Variant fine = plain;
  fine.name = "no shortcut, all bodies active, 960 Hz";
  PhysicsOptions& physics = fine.options.physics;
  physics.recover_share *= physics.rate_hz / 960;
  physics.rate_hz = 960;
  Variant fine_shifted = fine;
  fine_shifted.name = "960 Hz shifted, with 960 Hz";
  fine_shifted.shift_m = kShift_m;
  fine_shifted.reference = 4;
  return {default_variant, shifted, plain, active, fine, fine_shifted};
}

Grasp WithError(Grasp grasp, const GraspError& error, Rng& rng) {
  const Eigen::Vector3d off_m =
      error.error_m * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
  const Eigen::AngleAxisd rotation(error.error_rad * rng.Normal(), rng.UnitVector());
  grasp.X_WG = grasp.X_WG * Translation(off_m) * Pose(rotation);
  return grasp;
}

void MeasureAgreement(int attempts, const GraspError& error) {
  const auto loaded = LoadGripper("jaw_8cm");
  const Gripper& gripper = *loaded;
  const auto variants = Variants();
  std::vector<int> agree(variants.size(), 0), succeeded(variants.size(), 0);
  std::vector<double> seconds(variants.size(), 0);
  int done = 0;
  for (const ObjectCases& group : AllCases(gripper, AttemptsPerObject(attempts))) {
    for (const Case& one : group.cases) {
      if (done == attempts) break;
      Rng rng = Rng::Derive(0, done++, "shift");
      const Eigen::Vector3d direction_W = rng.UnitVector();
      const Grasp planned = WithError(one.grasp, error, rng);
      std::vector<bool> verdicts;
      std::vector<std::string> failures;
      for (size_t v = 0; v < variants.size(); ++v) {
        Grasp grasp = planned;
        grasp.X_WG = Translation(variants[v].shift_m * direction_W) * grasp.X_WG;
        const double begin_s = CpuSeconds();
        const GraspOutcome outcome =
            ExecuteGrasp(one.scene, group.objects, grasp, gripper, one.target, variants[v].options)
                .outcome;
        verdicts.push_back(outcome.success);
        failures.emplace_back(FailureName(outcome.failure));
        seconds[v] += CpuSeconds() - begin_s;
        succeeded[v] += verdicts[v];
        agree[v] += verdicts[v] == verdicts[variants[v].reference];
      }
      if (std::set<std::string>(failures.begin(), failures.end()).size() == 1) continue;
      fmt::print("{} {}: {}\n", group.name, done - 1, fmt::join(failures, ", "));
    }
    fmt::print("{:<10} done, {} attempts so far, agree", group.name, done);
    for (const int count : agree) fmt::print(" {}", count);
    fmt::print("\n");
    std::fflush(stdout);
  }
  for (size_t v = 0; v < variants.size(); ++v) {
    fmt::print("{:<40} {} of {} succeeded, {:.1f} % with the same outcome, {:.3f} CPU s each\n",
               variants[v].name, succeeded[v], done, 100.0 * agree[v] / done, seconds[v] / done);
  }
}

// Returns all numbers of an outcome, formatted so that they read back exactly.
std::string Label(const GraspOutcome& o) {
  std::string text =
      fmt::format("{} {} {} {} {} {} {} {} {}", FailureName(o.failure), o.picked_instance,
                  o.instances_lifted, o.final_opening_m, o.slip_m, o.in_hand_rotation_error_rad,
                  o.neighbors_displaced, o.lift_height_m, o.place_error_m);
  for (const bool verdict : o.verdicts) text += verdict ? " 1" : " 0";
  for (const double n : o.contact_force_n) text += fmt::format(" {}", n);
  for (const double nm : o.contact_torque_nm) text += fmt::format(" {}", nm);
  return text;
}

void MeasureLabels(int grasps) {
  const auto loaded = LoadGripper("jaw_8cm");
  const Gripper& gripper = *loaded;
  int done = 0, same = 0, succeeded = 0;
  uint64_t hash = 0;
  for (const ObjectCases& group : AllCases(gripper, AttemptsPerObject(grasps))) {
    for (const Case& one : group.cases) {
      if (done == grasps) break;
      ++done;
      std::array<GraspOutcome, 2> runs;
      for (GraspOutcome& outcome : runs) {
        outcome = ExecuteGrasp(one.scene, group.objects, one.grasp, gripper, one.target).outcome;
      }
      const std::string label = Label(runs[0]);
      same += label == Label(runs[1]);
      succeeded += runs[0].success;
      hash = HashBytes(label.data(), label.size(), hash);
    }
  }
  fmt::print(
      "labels: {} of {} grasps equal in every bit on a second run; {} succeeded; all labels "
      "{:016x}, to compare with another process\n",
      same, done, succeeded, hash);
}

int Main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[1] : "";
  const int count = argc == 3 ? std::atoi(argv[2]) : 0;
  if (count < 1) {
    fmt::print(stderr, "execute_figures speed|agreement|fickle|labels COUNT\n");
    return 1;
  }
  if (what == "speed") MeasureSpeed(count);
  if (what == "agreement") MeasureAgreement(count, {});
  if (what == "fickle") MeasureAgreement(count, kFickle);
  if (what == "labels") MeasureLabels(count);
  return 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) { return pickbed::tests::Main(argc, argv); }
