// The learned half of the descriptor estimator: patches, network and index, on one simulated pile.
// network/describe gives its share of the rate of SGEMM on the same core.

#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "eval/threads.h"
#include "perception/neighbors.h"
#include "perception/patch.h"
#include "perception/torch_model_file.h"
#include "scenes/files.h"
#include "scenes/object_catalog.h"
#include "sim/view_source.h"

namespace pickbed {
namespace {

constexpr int kPatches = 600;  // of a frame in mode fast
constexpr double kSide_m = 0.08;

// A pile of brackets, and where patches are cut.
struct Pile {
  OrganizedCloud cloud;
  std::vector<int> pixels;
  std::vector<double> angles_rad;
};

const Pile& BracketPile() {
  static const Pile pile = [] {
    const ObjectSet objects{ObjectCatalog({AssetsDir() / "objects"}).Load("bracket")};
    const LabelledView view = MakeSimViewSource(objects, {})->Pile({1, 1}).front();
    Pile p{BuildCloud(view.frame, view.background), {}, {}};
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
  return pile;
}

const DescriptorModel& Shipped() {
  UseOneThread();
  static const DescriptorModel model = LoadModel(TrainedFile("shipped"));
  return model;
}

void Patches(benchmark::State& state) {
  const Pile& pile = BracketPile();
  for (auto _ : state) {
    benchmark::DoNotOptimize(CutPatches(pile.cloud, pile.pixels, pile.angles_rad, {kSide_m}));
  }
  state.SetItemsProcessed(state.iterations() * kPatches);
}
BENCHMARK(Patches)->Name("patches/cut/600")->Unit(benchmark::kMillisecond);

void Describe(benchmark::State& state) {
  const Pile& pile = BracketPile();
  const DescriptorNetwork& network = Shipped().network;
  const PatchSet patches = CutPatches(pile.cloud, pile.pixels, pile.angles_rad, {kSide_m});
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

// Rows of unit length about as many centres as a part has views: a code book of twelve parts.
void Search(benchmark::State& state) {
  const auto rows = static_cast<int>(state.range(0));
  constexpr int kLength = 32, kRowsOfACentre = 20;
  Rng rng(5);
  const auto fill = [&](int count, std::vector<float>& values) {
    std::vector<double> centre(kLength);
    for (int i = 0; i < count; ++i) {
      if (i % kRowsOfACentre == 0) {
        for (double& c : centre) c = rng.Normal();
      }
      double squared = 0;
      std::vector<double> row(kLength);
      for (int k = 0; k < kLength; ++k) {
        row[k] = centre[k] + 0.4 * rng.Normal();
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
}  // namespace pickbed
