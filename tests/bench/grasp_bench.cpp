// Benchmarks of grasp candidates of an object, a plan for a bin of estimated poses, a plan without
// poses, one executed grasp, and rehearsals of a grasp.

#include <benchmark/benchmark.h>

#include "eval/cell/simulated_cell.h"
#include "eval/shapes/segment_shapes.h"
#include "grasp/candidates/candidates.h"
#include "grasp/cloud/cloud_antipodal.h"
#include "grasp/completed/rehearsal.h"
#include "grasp/execute/execute.h"
#include "grasp/grippers/parallel_jaw.h"
#include "grasp/grippers/table.h"
#include "grasp/grippers/tools.h"
#include "grasp/plan/plan.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/find_scenario.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/drop.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// A settled bin of brackets with all inputs of a pick. The cloud holds the surface samples that
// face up, without occlusion.
struct GraspBench {
  ObjectSet objects;
  ParallelJaw gripper;  // the defaults are the values of jaw_8cm
  std::vector<std::vector<GraspCandidate>> candidates;
  Scene scene;
  std::vector<EstimatedPose> poses;
  std::vector<Eigen::Vector3d> cloud_W;

  GraspBench(int instances, int candidates_each) {
    objects = WithConvexPieces(ObjectSet{ObjectCatalog({AssetsDir() / "objects"}).Load("bracket")});
    Rng rng(1);
    AntipodalOptions options;
    options.candidates = candidates_each;
    candidates.push_back(
        AntipodalGrasps(*objects[0], gripper.hand, gripper.clearance_m, rng, options));
    scene = DropInstances(Bin{}, objects, {instances}, rng).scene;
    const SurfaceSamples samples = SampleSurface(objects[0]->mesh_O, 5000, rng);
    for (const PosedObject& posed : scene.objects) {
      poses.push_back({posed.object, posed.X_WO, 1});
      for (size_t i = 0; i < samples.points.size(); ++i) {
        const Eigen::Vector3d normal_W = posed.X_WO.linear() * samples.normals[i];
        if (normal_W.z() > 0) cloud_W.push_back(posed.X_WO * samples.points[i]);
      }
    }
  }

  PlanResult Plan() const {
    return PlanGrasps({scene.bin, poses, candidates, cloud_W, objects, gripper});
  }
};

void PlanBin(benchmark::State& state, int candidates_each) {
  const GraspBench bench(20, candidates_each);
  for (auto _ : state) benchmark::DoNotOptimize(bench.Plan());
  state.SetItemsProcessed(state.iterations() * bench.poses.size() * bench.candidates[0].size());
}
BENCHMARK_CAPTURE(PlanBin, few, 200)->Name("grasp/plan/20x200")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(PlanBin, many, 2000)->Name("grasp/plan/20x2000")->Unit(benchmark::kMillisecond);

// Rehearsals of a grasp at all levels, with objects that are made anew or kept.
void Rehearse(benchmark::State& state, bool makes_objects) {
  const GraspBench bench(20, 2000);
  const PlanResult plan = bench.Plan();
  if (plan.grasps.empty()) {
    state.SkipWithError("no grasp in the bin");
    return;
  }
  const Grasp& grasp = plan.grasps.front();
  const std::vector<OccupancyShape> shapes{
      ShapeOfMesh(bench.objects[0]->mesh_O, bench.scene.objects[grasp.hypothesis].X_WO)};
  Rehearsal kept(shapes, Pose::Identity(), {}, Bin().friction);
  for (auto _ : state) {
    if (makes_objects) kept = Rehearsal(shapes, Pose::Identity(), {}, Bin().friction);
    benchmark::DoNotOptimize(kept.FailuresOf(grasp, bench.gripper));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(Rehearse, first, true)
    ->Name("grasp/rehearse/first")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Rehearse, next, false)
    ->Name("grasp/rehearse/next")
    ->Unit(benchmark::kMillisecond);

// 500 grasps of a new object with all their qualities.
void Candidates(benchmark::State& state, const char* gripper_name) {
  const auto bracket = ObjectCatalog({AssetsDir() / "objects"}).Load("bracket");
  const auto gripper = LoadGripper(gripper_name);
  GraspCandidateOptions options;
  options.antipodal.candidates = options.suction.candidates = 500;
  for (auto _ : state) {
    Rng rng(1);
    benchmark::DoNotOptimize(MakeCandidates(*bracket, *gripper, rng, options));
  }
  state.SetItemsProcessed(state.iterations() * 500);
}
BENCHMARK_CAPTURE(Candidates, jaw, "jaw_8cm")
    ->Name("grasp/candidates/jaw500")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Candidates, cup, "cup_30mm")
    ->Name("grasp/candidates/cup500")
    ->Unit(benchmark::kMillisecond);

void Execute(benchmark::State& state) {
  const GraspBench bench(20, 2000);
  const PlanResult plan = bench.Plan();
  if (plan.grasps.empty()) {
    state.SkipWithError("no grasp in the bin");
    return;
  }
  const Grasp& grasp = plan.grasps.front();
  const InstanceId target = bench.scene.objects[grasp.hypothesis].instance;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        ExecuteGrasp(bench.scene, bench.objects, grasp, bench.gripper, target));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Execute)->Name("grasp/execute/20parts")->Unit(benchmark::kMillisecond);

void Antipodal(benchmark::State& state) {
  const auto bracket = ObjectCatalog({AssetsDir() / "objects"}).Load("bracket");
  const ParallelJaw jaw;  // the defaults are the values of jaw_8cm
  for (auto _ : state) {
    Rng rng(1);
    benchmark::DoNotOptimize(AntipodalGrasps(*bracket, jaw.hand, jaw.clearance_m, rng));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Antipodal)->Name("grasp/antipodal/bracket")->Unit(benchmark::kMillisecond);

// Planning without poses on an image of the scenario "clutter".
void CloudPlanning(benchmark::State& state, const char* scenario, double max_tilt_deg) {
  const LoadedScenario loaded = FindScenario({scenario, {}, "objects", {}});
  SimulatedCell cell(loaded.spec, loaded.objects);
  const Observation view = cell.Capture(cell.MakeScene(BinIndex(0)).scene, BinIndex(0), 0);
  const Tools tools = LoadTools(loaded.spec.gripper.names);
  PlannerSpec spec;
  spec.max_tilt_deg = max_tilt_deg;
  const ObjectSet no_objects;
  const std::vector<std::vector<std::vector<GraspCandidate>>> no_candidates;
  CloudAntipodal planner({spec, tools, no_objects, no_candidates, {}, 2});
  const PlannerInput input{view.frame, cell.camera().X_WC(),
                           BinPlacement{cell.bin(), Pose::Identity()}};
  for (auto _ : state) benchmark::DoNotOptimize(planner.Plan(input));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(CloudPlanning, vertical, "clutter", 0)
    ->Name("grasp/cloud_antipodal/clutter/vertical")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CloudPlanning, tilted, "clutter", PlannerSpec().max_tilt_deg)
    ->Name("grasp/cloud_antipodal/clutter/tilted")
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(CloudPlanning, mixed, "bin_mixed", PlannerSpec().max_tilt_deg)
    ->Name("grasp/cloud_antipodal/bin_mixed/tilted")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pickbed::tests
