#include <benchmark/benchmark.h>

#include <filesystem>

#include "perception/estimators/pose_estimator.h"
#include "scenes/base/files.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/plugin_scripts.h"

// Overhead of the plug-in protocol: an image of 1224 x 1024 px with color and depth goes to a
// Python program, which answers with one pose at once.

namespace pickbed::tests {
namespace {

void PythonEstimator(benchmark::State& state) {
  const TemporaryFolder folder;
  RgbdFrame frame;
  frame.intrinsics = {1224, 1024, 1200, 1200, 611.5, 511.5};
  frame.depth_m = Image<float>(1224, 1024, 0.8f);
  frame.color = Image<Rgb8>(1224, 1024, Rgb8{90, 80, 70});
  EstimatorSetup setup;
  setup.objects = EasyCube();
  setup.spec.name = "process";
  setup.spec.command = PythonCommand(folder, "estimator.py", EstimatorCode("    return [pose()]"));
  setup.intrinsics = frame.intrinsics;
  setup.cache_dir = folder.path();
  const auto estimator = MakeEstimator(setup);
  Rng rng(1);
  for (auto _ : state) {
    const EstimateResult result = estimator->Estimate({frame, std::nullopt}, rng);
    if (result.hypotheses.size() != 1) state.SkipWithError("no pose");
  }
  state.SetBytesProcessed(state.iterations() * (frame.depth_m.size() * sizeof(float) +
                                                frame.color.size() * sizeof(Rgb8)));
}
BENCHMARK(PythonEstimator)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace pickbed::tests
