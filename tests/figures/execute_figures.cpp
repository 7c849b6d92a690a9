// Long measurements of grasps in full bins, with the figures on stdout:
//   execute_figures speed ATTEMPTS      CPU seconds from approach to shake, ATTEMPTS of each part
//   execute_figures agreement ATTEMPTS  verdicts beside those of slower and finer physics, of
//   grasps
//                                       as planned
//   execute_figures fickle ATTEMPTS     the same with pose errors, which make many of them close
//   execute_figures labels GRASPS       labels of two runs over the same grasps
// A bin holds the part that is picked and 20 neighbours of its kind; poses are the true ones.

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

#include "grasp/candidates.h"
#include "grasp/execute.h"
#include "grasp/plan.h"
#include "scenes/object_catalog.h"
#include "sim/convex_pieces.h"
#include "sim/scene_maker.h"

namespace pickbed {
namespace {

constexpr int kParts = 21;
constexpr int kEachScene = 7;        // attempts on one bin at most, each on another part
constexpr int kGraspsPlanned = 300;  // to find as many parts that can be reached
constexpr double kShift_m = 1e-4;    // of the gripper, to see how fickle verdicts are

// Sigmas of an error added to grasps, as wrong poses do.
struct GraspError {
  double error_m = 0;
  double error_rad = 0;
};

// Those planned with true poses succeed nearly all; with these about half do.
constexpr GraspError kFickle{0.004, 0.08};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// A grasp that a planner with true poses would make, in its bin.
struct Case {
  Scene scene;
  Grasp grasp;
  int target = -1;
};

struct PartCases {
  std::string name;
  ObjectSet objects;
  std::vector<Case> cases;
};

// What the parts show to the sky.
std::vector<Eigen::Vector3d> CloudOf(const Scene& scene, const ObjectModel& model) {
  Rng rng(1);
  const SurfaceSamples samples = SampleSurface(model.mesh_O, 3000, rng);
  std::vector<Eigen::Vector3d> cloud_W;
  for (const PosedObject& part : scene.objects) {
    for (size_t i = 0; i < samples.points.size(); ++i) {
      const Eigen::Vector3d normal_W = part.X_WO.linear() * samples.normals[i];
      if (normal_W.z() > 0) cloud_W.push_back(part.X_WO * samples.points[i]);
    }
  }
  return cloud_W;
}

// One grasp of each part that can be reached, drawn at random of those that were planned: the best
// ones alone would hardly ever fail.
std::vector<Case> CasesOf(const Scene& scene, const ObjectSet& objects,
                          const std::vector<GraspCandidate>& candidates, const GripperSpec& gripper,
                          Rng& rng) {
  std::vector<BelievedPose> poses;
  for (const PosedObject& part : scene.objects) poses.push_back({part.object, part.X_WO, 1});
  PlanOptions options;
  options.max_grasps = kGraspsPlanned;
  const std::vector<std::vector<GraspCandidate>> all{candidates};
  const auto cloud_W = CloudOf(scene, *objects[0]);
  const PlanResult plan = PlanGrasps({scene.bin, poses, all, cloud_W, objects, gripper}, options);
  std::map<int, std::vector<Grasp>> by_part;
  for (const Grasp& grasp : plan.grasps) by_part[grasp.hypothesis].push_back(grasp);
  std::vector<Case> cases;
  for (const auto& [part, grasps] : by_part) {
    const Grasp& grasp = grasps[rng.Index(static_cast<int>(grasps.size()))];
    if (static_cast<int>(cases.size()) == kEachScene) break;
    cases.push_back({scene, grasp, scene.objects[part].instance});
  }
  return cases;
}

PartCases MakeCases(const std::string& name, const GripperSpec& gripper, int attempts) {
  PartCases part{
      name, WithConvexPieces(ObjectSet{ObjectCatalog({AssetsDir() / "objects"}).Load(name)}), {}};
  Bin bin;  // of the part's size, as those of the presets bin_PART
  bin.inner_size_m = Eigen::Vector3d(4, 3, 1.5) * part.objects[0]->diameter_m;
  const auto candidates = CachedCandidates(*part.objects[0], gripper);
  for (uint64_t trial = 0; static_cast<int>(part.cases.size()) < attempts; ++trial) {
    Rng rng = Rng::Derive(0, trial, "grasps");
    const CertifiedScene made = MakeScene({bin, part.objects, {kParts}, 0, trial});
    for (Case& found : CasesOf(made.scene, part.objects, candidates, gripper, rng)) {
      if (static_cast<int>(part.cases.size()) < attempts) part.cases.push_back(std::move(found));
    }
    if (trial > static_cast<uint64_t>(attempts)) break;  // a part that is hardly ever reached
  }
  return part;
}

std::vector<PartCases> AllCases(const GripperSpec& gripper, int attempts_each) {
  std::vector<PartCases> all;
  for (const std::string& name : ObjectCatalog({AssetsDir() / "objects"}).Names()) {
    all.push_back(MakeCases(name, gripper, attempts_each));
  }
  return all;
}

int EachPart(int attempts) {
  const int parts = static_cast<int>(ObjectCatalog({AssetsDir() / "objects"}).Names().size());
  return (attempts + parts - 1) / parts;
}

void MeasureSpeed(int attempts) {
  const GripperSpec gripper = LoadGripper("jaw_8cm");
  ExecuteOptions options;
  options.carry = false;
  double mean_of_means_s = 0;
  const auto parts = AllCases(gripper, attempts);
  for (const PartCases& part : parts) {
    double sum_s = 0, slowest_s = 0;
    int succeeded = 0;
    for (const Case& one : part.cases) {
      const double begin_s = CpuSeconds();
      const ExecuteResult result =
          ExecuteGrasp(one.scene, part.objects, one.grasp, gripper, one.target, options);
      const double took_s = CpuSeconds() - begin_s;
      sum_s += took_s;
      slowest_s = std::max(slowest_s, took_s);
      succeeded += result.outcome.success;
    }
    const double mean_s = sum_s / static_cast<double>(std::max<size_t>(1, part.cases.size()));
    mean_of_means_s += mean_s / static_cast<double>(parts.size());
    fmt::print("{:<10} {:.3f} CPU s a full attempt, slowest {:.3f}; {} of {} succeeded\n",
               part.name, mean_s, slowest_s, succeeded, part.cases.size());
    std::fflush(stdout);
  }
  fmt::print("speed: {:.4f} CPU s a full attempt, mean of {} parts\n", mean_of_means_s,
             parts.size());
}

// A way to run all attempts.
struct Variant {
  std::string name;
  ExecuteOptions options;
  double shift_m = 0;  // of the gripper, in a direction of its own for each attempt
  int beside = 0;      // the variant whose verdicts are compared with its own
};

std::vector<Variant> Variants() {
  Variant usual{"usual", {}, 0};
  Variant shifted{"gripper shifted by 0.1 mm", {}, kShift_m};
  Variant plain{"nothing spared in a step", {}, 0};
  plain.options.physics = PhysicsOptions();
  Variant active = plain;
  active.name = "that and all bodies active";
  active.options.world.all_active = true;
  Variant fine = plain;
  fine.name = "that at 960 Hz";
  PhysicsOptions& physics = fine.options.physics;
  physics.recover_share *= physics.rate_hz / 960;
  physics.rate_hz = 960;
  Variant fine_shifted = fine;
  fine_shifted.name = "960 Hz shifted, with 960 Hz";
  fine_shifted.shift_m = kShift_m;
  fine_shifted.beside = 4;
  return {usual, shifted, plain, active, fine, fine_shifted};
}

Grasp Disturbed(Grasp grasp, const GraspError& error, Rng& rng) {
  const Eigen::Vector3d off_m =
      error.error_m * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
  const Eigen::AngleAxisd turn(error.error_rad * rng.Normal(), rng.UnitVector());
  grasp.X_WG = grasp.X_WG * Translation(off_m) * Pose(turn);
  return grasp;
}

void MeasureAgreement(int attempts, const GraspError& error) {
  const GripperSpec gripper = LoadGripper("jaw_8cm");
  const auto variants = Variants();
  std::vector<int> agree(variants.size(), 0), succeeded(variants.size(), 0);
  std::vector<double> seconds(variants.size(), 0);
  int done = 0;
  for (const PartCases& part : AllCases(gripper, EachPart(attempts))) {
    for (const Case& one : part.cases) {
      if (done == attempts) break;
      Rng rng = Rng::Derive(0, done++, "shift");
      const Eigen::Vector3d direction_W = rng.UnitVector();
      const Grasp planned = Disturbed(one.grasp, error, rng);
      std::vector<bool> verdicts;
      std::vector<std::string> losses;
      for (size_t v = 0; v < variants.size(); ++v) {
        Grasp grasp = planned;
        grasp.X_WG = Translation(variants[v].shift_m * direction_W) * grasp.X_WG;
        const double begin_s = CpuSeconds();
        const GraspOutcome outcome =
            ExecuteGrasp(one.scene, part.objects, grasp, gripper, one.target, variants[v].options)
                .outcome;
        verdicts.push_back(outcome.success);
        losses.emplace_back(LossName(outcome.loss));
        seconds[v] += CpuSeconds() - begin_s;
        succeeded[v] += verdicts[v];
        agree[v] += verdicts[v] == verdicts[variants[v].beside];
      }
      if (std::set<std::string>(losses.begin(), losses.end()).size() == 1) continue;
      fmt::print("{} {}: {}\n", part.name, done - 1, fmt::join(losses, ", "));
    }
    fmt::print("{:<10} done, {} attempts so far, agree", part.name, done);
    for (const int count : agree) fmt::print(" {}", count);
    fmt::print("\n");
    std::fflush(stdout);
  }
  for (size_t v = 0; v < variants.size(); ++v) {
    fmt::print("{:<26} {} of {} succeeded, {:.1f} % the same verdict, {:.3f} CPU s each\n",
               variants[v].name, succeeded[v], done, 100.0 * agree[v] / done, seconds[v] / done);
  }
}

// All that was found out about a grasp, every number so that it reads back the same.
std::string Label(const GraspOutcome& o) {
  std::string text = fmt::format("{} {} {} {} {} {} {} {} {}", LossName(o.loss), o.picked_instance,
                                 o.parts_lifted, o.final_opening_m, o.slip_m, o.turn_rad,
                                 o.disturbed, o.lift_height_m, o.place_error_m);
  for (const bool verdict : o.verdicts) text += verdict ? " 1" : " 0";
  for (const double n : o.contact_force_n) text += fmt::format(" {}", n);
  for (const double nm : o.contact_torque_nm) text += fmt::format(" {}", nm);
  return text;
}

void MeasureLabels(int grasps) {
  const GripperSpec gripper = LoadGripper("jaw_8cm");
  int done = 0, same = 0, succeeded = 0;
  uint64_t hash = 0;
  for (const PartCases& part : AllCases(gripper, EachPart(grasps))) {
    for (const Case& one : part.cases) {
      if (done == grasps) break;
      ++done;
      std::array<GraspOutcome, 2> runs;
      for (GraspOutcome& outcome : runs) {
        outcome = ExecuteGrasp(one.scene, part.objects, one.grasp, gripper, one.target).outcome;
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
}  // namespace pickbed

int main(int argc, char** argv) { return pickbed::Main(argc, argv); }
