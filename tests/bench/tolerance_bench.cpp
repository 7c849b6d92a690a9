// Benchmarks of fitting a tolerance model to executed grasps, and of scoring a pose with it.

#include <benchmark/benchmark.h>

#include "grasp/tolerance/tolerance_model.h"
#include "scenes/base/random.h"
#include "scenes/objects/object_catalog.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kGrasps = 40;

PoseOffset RandomError(Rng& rng) {
  PoseOffset error;
  for (int i = 0; i < 6; ++i) error[i] = (i < 3 ? 0.01 : 0.4) * rng.Uniform(-1, 1);
  return error;
}

// The flange has a continuous axis, which is discretized into 314 ambiguous poses.
ToleranceModel FlangeModel(Rng& rng) {
  std::vector<Pose> X_OG;
  for (int i = 0; i < kGrasps; ++i) {
    X_OG.push_back(MakePose(rng.Rotation().toRotationMatrix(), 0.02 * rng.UnitVector()));
  }
  return EmptyToleranceModel(*ObjectCatalog({AssetsDir() / "objects"}).Load("flange"), "jaw_8cm",
                             X_OG);
}

void Score(benchmark::State& state) {
  Rng rng(1);
  const ToleranceModel model = FlangeModel(rng);
  for (auto _ : state) {
    benchmark::DoNotOptimize(SuccessProbability(model, ToPose(RandomError(rng))));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(Score)->Name("grasp/tolerance_score/40grasps")->Unit(benchmark::kMicrosecond);

void Fit(benchmark::State& state) {
  Rng rng(1);
  ToleranceModel model = FlangeModel(rng);
  std::vector<ToleranceSample> samples;
  for (int i = 0; i < state.range(0); ++i) {
    const PoseOffset error = RandomError(rng);
    samples.push_back({error, error.head<3>().norm() < 0.01 * rng.Uniform(), i % kGrasps});
  }
  for (auto _ : state) FitTolerance(samples, {}, model);
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(Fit)
    ->Name("grasp/tolerance_fit/grasps")
    ->Arg(1000)
    ->Arg(10000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pickbed::tests
