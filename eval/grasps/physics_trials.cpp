#include "eval/grasps/physics_trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <optional>
#include <sstream>

#include "eval/cell/simulated_cell.h"
#include "grasp/plan/plan.h"
#include "scenes/geometry/symmetry.h"

namespace pickbed::eval {
namespace {

// A planned grasp, or why there is none.
struct Planned {
  std::optional<Grasp> grasp;
  std::string blocked;
};

// Returns the candidate in each pose that the symmetries of the object make equivalent.
std::vector<GraspCandidate> SymmetricCandidates(const ObjectModel& object,
                                                const GraspCandidate& candidate) {
  constexpr int kRotations = 12;  // about an axis of continuous symmetry
  std::vector<GraspCandidate> candidates;
  for (const Pose& X_OS : SymmetryTransforms(object.symmetries_O, kRotations)) {
    candidates.push_back(candidate);
    candidates.back().X_OG = X_OS * candidate.X_OG;
  }
  return candidates;
}

// Plans the candidate for all instances of a scene with their true poses, and returns the best one.
Planned PlanInScene(const GraspTestJob& job, const Scene& scene, const GraspCandidate& candidate,
                    double max_tilt_rad) {
  std::vector<EstimatedPose> poses;
  for (const PosedObject& posed : scene.objects) poses.push_back({ObjectId{0}, posed.X_WO, 1});
  const std::vector<std::vector<GraspCandidate>> by_object{
      SymmetricCandidates(*job.object, candidate)};
  const ObjectSet objects{job.object};
  PlanOptions options;
  options.max_grasps = 1;
  options.max_tilt_rad = max_tilt_rad;
  options.min_quality = options.relaxed.min_quality = 0;  // the grasp is given
  PlanResult plan = PlanGrasps({scene.bin, poses, by_object, {}, objects, *job.gripper}, options);
  if (!plan.grasps.empty()) return {std::move(plan.grasps.front()), ""};
  const auto cause = std::ranges::max_element(
      plan.rejected, {}, [](const auto& rejection) { return rejection.second; });
  return {std::nullopt, cause == plan.rejected.end() ? "no grasp" : cause->first};
}

GraspOutcome Executed(const GraspTestJob& job, const Scene& scene, const Grasp& grasp,
                      const ExecuteOptions& options) {
  const PosedObject& target = scene.objects.at(grasp.hypothesis);
  return ExecuteGrasp(scene, {job.object}, grasp, *job.gripper, target.instance, options).outcome;
}

// Reply of a worker: place, success, failure, slip, retention, then the cause.
std::string TestOnTable(const GraspTestJob& job, const std::vector<RestingPlace>& places,
                        int grasp) {
  ExecuteOptions options = job.options.execute;
  options.retention = job.options.hold;
  std::string blocked;
  for (size_t place = 0; place < places.size(); ++place) {
    const Scene& scene = places[place].scene;
    const Planned planned =
        PlanInScene(job, scene, job.candidates[grasp], /*max_tilt_rad=*/std::numbers::pi);
    if (blocked.empty()) blocked = planned.blocked;
    if (!planned.grasp) continue;
    const GraspOutcome outcome = Executed(job, scene, *planned.grasp, options);
    return fmt::format("{} {} {} {} {}", place, outcome.success ? 1 : 0,
                       FailureName(outcome.failure), outcome.slip_m, outcome.retention_g);
  }
  return fmt::format("-1 0 {} 0 -1 {}", FailureName(FailureReason::kNoGrasp), blocked);
}

void ReadTableReply(const std::string& reply, GraspTest& test) {
  std::istringstream in(reply);
  int success = 0;
  std::string failure;
  in >> test.place >> success >> failure >> test.on_table.slip_m >> test.on_table.retention_g;
  test.on_table.success = success == 1;
  test.on_table.failure = FailureFromName(failure).value_or(FailureReason::kPhysicsFailed);
  std::getline(in >> std::ws, test.blocked);
}

ScenarioSpec ScenarioOfBins(const GraspTestJob& job) {
  ScenarioSpec spec;
  spec.seed = job.options.seed;
  spec.objects.resize(1);
  spec.objects[0].name = job.object->name;
  spec.objects[0].count = job.options.instances;
  return spec;
}

// Reply of a worker for one bin: for each grasp 0 (not reachable), 1 (failed) or 2 (picked).
std::string TestInBin(const GraspTestJob& job, const SimulatedCell& cell,
                      const std::vector<int>& grasps, int bin) {
  const Scene scene = cell.MakeScene(BinIndex(bin)).scene;
  std::string reply;
  for (const int grasp : grasps) {
    const Planned planned =
        PlanInScene(job, scene, job.candidates[grasp], PlanOptions().max_tilt_rad);
    if (!planned.grasp) {
      reply += '0';
      continue;
    }
    reply += Executed(job, scene, *planned.grasp, job.options.execute).success ? '2' : '1';
  }
  return reply;
}

// An even selection of `count` of `all` indices.
std::vector<int> EvenSelection(int all, int count) {
  std::vector<int> selected;
  for (int i = 0; i < std::min(all, count); ++i) {
    selected.push_back(static_cast<int>(static_cast<int64_t>(i) * all / std::min(all, count)));
  }
  return selected;
}

// Processes the items in workers. Returns false if it was stopped.
bool RunItems(const GraspTestJob& job, const std::string& what, int items,
              const std::function<WorkerPlan::DoItem()>& start,
              const std::function<void(int item, const std::string& reply)>& on_done) {
  WorkerPlan plan;
  for (int i = 0; i < items; ++i) plan.items.push_back(i);
  plan.jobs = std::max(1, std::min(job.jobs, items));
  plan.start = [&](const WorkerPlan::Say&) { return start(); };
  int done = 0;
  plan.on_done = [&](int item, const std::string& reply) {
    on_done(item, reply);
    if (job.on_progress) job.on_progress(what, ++done, items);
  };
  plan.stop = job.stop;
  const WorkReport report = RunInWorkers(plan);
  if (!report.lost.empty() && !report.stopped) {
    throw std::runtime_error(
        fmt::format("{} {} failed: {}", what, report.lost.front().item, report.lost.front().why));
  }
  return !report.stopped;
}

}  // namespace

void GraspTestOptions::Visit(SettingsVisitor& v) {
  v.Integer("max_grasps", max_grasps, {1, 1000000},
            "maximum number of tested grasps; of more, an even selection in the order of the file");
  v.Integer("bins", bins, {0, 10000}, "number of filled bins; 0 = only the table");
  v.Integer("instances", instances, {1, 1000}, "number of instances in each bin");
  v.Seed("seed", seed, "random seed of the bins");
  v.Group(
      "hold", [this](SettingsVisitor& g) { hold.Visit(g); }, "hold test on the table");
  v.Group(
      "table", [this](SettingsVisitor& g) { table.Visit(g); }, "the table");
  v.Group(
      "execute", [this](SettingsVisitor& g) { execute.Visit(g); }, "execution of a grasp");
}

GraspTests TestGrasps(const GraspTestJob& job) {
  CheckSettings("GraspTestOptions", job.options);
  const std::vector<RestingPlace> places = RestingPlacesOf(*job.object, job.options.table);
  const std::vector<int> grasps =
      EvenSelection(static_cast<int>(job.candidates.size()), job.options.max_grasps);
  GraspTests result;
  for (const int grasp : grasps) result.tests.emplace_back().grasp = grasp;
  const bool on_table = RunItems(
      job, "grasp", static_cast<int>(grasps.size()),
      [&] { return [&](int item) { return TestOnTable(job, places, grasps[item]); }; },
      [&](int item, const std::string& reply) { ReadTableReply(reply, result.tests[item]); });
  for (GraspTest& test : result.tests) test.in_bins.resize(job.options.bins);
  const SimulatedCell cell(ScenarioOfBins(job), {job.object});
  const bool in_bins =
      on_table && RunItems(
                      job, "bin", job.options.bins,
                      [&] { return [&](int bin) { return TestInBin(job, cell, grasps, bin); }; },
                      [&](int bin, const std::string& reply) {
                        for (size_t i = 0; i < reply.size(); ++i) {
                          result.tests[i].in_bins[bin] = {reply[i] == '2', reply[i] != '0'};
                        }
                      });
  if (in_bins) return result;
  return {{}, true};
}

}  // namespace pickbed::eval
