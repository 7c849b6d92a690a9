// Benchmarks of sampled shapes: signed distances, drawing a shape and its mesh.

#include <benchmark/benchmark.h>

#include "scenes/base/random.h"
#include "scenes/shape_families/shape_family.h"
#include "scenes/shape_families/solid_mesh.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr const char* kBenchFamilies[] = {"tube", "flange", "mug", "tray", "random_union"};

SampledShape BenchShape(const benchmark::State& state) {
  return SampleShape(FindShapeFamily(kBenchFamilies[state.range(0)]), ShapeSplit::kSeen, 1);
}

// Items are points.
void BM_SignedDistances(benchmark::State& state) {
  const SampledShape shape = BenchShape(state);
  state.SetLabel(shape.family->name);
  Rng rng(1);
  std::vector<Eigen::Vector3f> points(4096);
  std::vector<float> distances(points.size());
  for (Eigen::Vector3f& p : points) p = 0.08f * rng.UnitVector().cast<float>();
  for (auto _ : state) {
    shape.solid.SignedDistances_m(points, distances);
    benchmark::DoNotOptimize(distances.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(points.size()));
}
BENCHMARK(BM_SignedDistances)->Name("signed_distances/family")->DenseRange(0, 4);

void BM_SampleShape(benchmark::State& state) {
  const ShapeFamilyRow& row = FindShapeFamily(kBenchFamilies[state.range(0)]);
  state.SetLabel(row.name);
  uint64_t seed = 0;
  for (auto _ : state) benchmark::DoNotOptimize(SampleShape(row, ShapeSplit::kSeen, seed++));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_SampleShape)->Name("sample_shape/family")->DenseRange(0, 4);

void BM_MeshOfSolid(benchmark::State& state) {
  const SampledShape shape = BenchShape(state);
  state.SetLabel(shape.family->name);
  for (auto _ : state) benchmark::DoNotOptimize(MeshOfSolid(shape.solid));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_MeshOfSolid)->Name("mesh_of_solid/family")->DenseRange(0, 4);

}  // namespace
}  // namespace pickbed::tests
