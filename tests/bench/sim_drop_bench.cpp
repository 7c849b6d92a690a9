#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/drop.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

ObjectSet ShippedObjects() {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  ObjectSet objects;
  for (const std::string& name : catalog.Names()) objects.push_back(catalog.Load(name));
  return WithConvexPieces(objects);
}

// One scene can take three times as long as another, so each value is a mean over this many scenes.
constexpr int kScenes = 8;

// Drops state.range(0) instances, evenly distributed over all shipped objects, with another seed in
// each iteration.
void DropMixedInstances(benchmark::State& state) {
  const ObjectSet objects = ShippedObjects();
  std::vector<int> counts(objects.size(), 0);
  for (int i = 0; i < state.range(0); ++i) ++counts[i % counts.size()];
  uint64_t seed = 0;
  double simulated_s = 0, worst_mm = 0;
  int at_rest = 0;
  for (auto _ : state) {
    Rng rng(seed++);
    const DropResult drop = DropInstances(Bin{}, objects, counts, rng);
    simulated_s += drop.certificate.simulated_s;
    at_rest += drop.certificate.at_rest;
    worst_mm = std::max(worst_mm, 1e3 * drop.certificate.deepest_penetration_m);
  }
  const auto mean = benchmark::Counter::kAvgIterations;
  state.counters["simulated_s"] = benchmark::Counter(simulated_s, mean);
  state.counters["at_rest"] = benchmark::Counter(at_rest, mean);
  state.counters["deepest_mm"] = worst_mm;
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(DropMixedInstances)
    ->Name("drop/mixed20/1core")
    ->Arg(20)
    ->Iterations(kScenes)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(DropMixedInstances)
    ->Name("drop/mixed50/1core")
    ->Arg(50)
    ->Iterations(kScenes)
    ->Unit(benchmark::kMillisecond);

void DecomposeShippedObjects(benchmark::State& state) {
  const ObjectSet objects = ShippedObjects();
  for (auto _ : state) {
    for (const auto& object : objects) {
      benchmark::DoNotOptimize(DecomposeConvex(object->mesh_O));
    }
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int>(objects.size()));
}
BENCHMARK(DecomposeShippedObjects)->Name("decompose/shipped/1core")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pickbed::tests
