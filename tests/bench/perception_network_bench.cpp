// Benchmarks of the learned part of the descriptor estimator on one simulated clutter scene:
// patches, network and index. network/describe reports its rate relative to SGEMM on the same core.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "eval/runtime/process.h"
#include "perception/completion/network_completer.h"
#include "perception/completion/shape_completer.h"
#include "perception/completion/training_sample.h"
#include "perception/features/neighbors.h"
#include "perception/features/patch.h"
#include "perception/networks/model_file.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "sim/training_view_source.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kPatches = 600;  // patches per frame in mode fast
constexpr double kSide_m = 0.08;

// A clutter scene of brackets, and the pixels and angles of the patches.
struct BracketScene {
  OrganizedCloud cloud;
  std::vector<int> pixels;
  std::vector<double> angles_rad;
};

const BracketScene& SharedScene() {
  static const BracketScene scene = [] {
    const ObjectSet objects{ObjectCatalog({AssetsDir() / "objects"}).Load("bracket")};
    const LabelledView view = MakeSimViewSource(objects, {})->ClutterScene({1, 1}).front();
    BracketScene p{BuildCloud(view.frame, view.background), {}, {}};
    Rng rng(3);
    while (p.pixels.size() < kPatches) {
      const int pixel =
          p.cloud.foreground_pixels[rng.Index(static_cast<int>(p.cloud.foreground_pixels.size()))];
      if (p.cloud.normals_C[pixel].isZero(0)) continue;
      p.pixels.push_back(pixel);
      p.angles_rad.push_back(rng.Uniform(0, 2 * std::numbers::pi));
    }
    return p;
  }();
  return scene;
}

const DescriptorModel& Shipped() {
  UseOneThread();
  static const DescriptorModel model = LoadModel(TrainedFile("shipped"));
  return model;
}

// Completion of a carton's view on 64^3 cells. The weights do not change the time.
void Complete(benchmark::State& state) {
  UseOneThread();
  const auto solid = SolidOf(SampleShape(FindShapeFamily("carton"), ShapeSplit::kSeen, 1).solid);
  Rng rng(1);
  const RandomView drawn = DrawView(*solid, {}, {}, rng);
  const CompletionNetwork network(CompletionNetworkOptions{}, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        CompleteWithNetwork(network, drawn.view, 64, CompletionOptions().turns));
  }
}
BENCHMARK(Complete)->Name("completion/network/64")->Unit(benchmark::kMillisecond);

// A training step of the completion network with 16 views. With two replicas it uses two cores.
void TrainCompletionStep(benchmark::State& state) {
  UseOneThread();
  const auto solid = SolidOf(SampleShape(FindShapeFamily("carton"), ShapeSplit::kSeen, 1).solid);
  Rng rng(1);
  const CompletionSample sample = MakeSample(*solid, DrawView(*solid, {}, {}, rng), 2048, rng);
  const std::vector<TurnedSample> views(16, {&sample, 0});
  const CompletionBatch batch = BatchOf(views);
  CompletionNetwork network(CompletionNetworkOptions{}, 1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(network.TrainStep(batch, 1e-3, static_cast<int>(state.range(0))));
  }
}
BENCHMARK(TrainCompletionStep)
    ->Name("completion/train_step/replicas")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void Patches(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  for (auto _ : state) {
    benchmark::DoNotOptimize(CutPatches(scene.cloud, scene.pixels, scene.angles_rad, {kSide_m}));
  }
  state.SetItemsProcessed(state.iterations() * kPatches);
}
BENCHMARK(Patches)->Name("patches/cut/600")->Unit(benchmark::kMillisecond);

void Describe(benchmark::State& state) {
  const BracketScene& scene = SharedScene();
  const DescriptorNetwork& network = Shipped().network;
  const PatchSet patches = CutPatches(scene.cloud, scene.pixels, scene.angles_rad, {kSide_m});
  const double sgemm_rate = SgemmRate();
  const auto start = std::chrono::steady_clock::now();
  for (auto _ : state) benchmark::DoNotOptimize(network.Describe(patches.values));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  state.SetItemsProcessed(state.iterations() * kPatches);
  const double rate =
      static_cast<double>(state.iterations()) * kPatches * network.MultiplyAdds() / seconds.count();
  state.counters["multiply_adds_per_s"] = rate;
  state.counters["share_of_sgemm"] = rate / sgemm_rate;
}
BENCHMARK(Describe)->Name("network/describe/600")->Unit(benchmark::kMillisecond);

// Rows of unit length around as many centers as an object has views. 600,000 rows are a code book
// of twelve objects.
void Search(benchmark::State& state) {
  const auto rows = static_cast<int>(state.range(0));
  constexpr int kLength = 32, kRowsPerCenter = 20;
  Rng rng(5);
  const auto fill = [&](int count, std::vector<float>& values) {
    std::vector<double> center(kLength);
    for (int i = 0; i < count; ++i) {
      if (i % kRowsPerCenter == 0) {
        for (double& c : center) c = rng.Normal();
      }
      double squared = 0;
      std::vector<double> row(kLength);
      for (int k = 0; k < kLength; ++k) {
        row[k] = center[k] + 0.4 * rng.Normal();
        squared += row[k] * row[k];
      }
      for (const double value : row) {
        values.push_back(static_cast<float>(value / std::sqrt(squared)));
      }
    }
  };
  std::vector<float> book, queries;
  fill(rows, book);
  fill(kPatches, queries);
  const NeighborIndex index(std::move(book), kLength);
  for (auto _ : state) benchmark::DoNotOptimize(index.Search(queries, 8));
  state.SetItemsProcessed(state.iterations() * kPatches);
}
BENCHMARK(Search)
    ->Name("index/600_queries_8")
    ->Arg(50000)
    ->Arg(600000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pickbed::tests
