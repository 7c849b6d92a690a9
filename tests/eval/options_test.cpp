#include <gtest/gtest.h>

#include "eval/benchmark/crops.h"
#include "eval/cell/simulated_cell.h"
#include "eval/stats/sequential_stop.h"
#include "eval/sweep/slurm.h"
#include "eval/sweep/sweep.h"
#include "eval/tolerance/samples.h"
#include "eval/trial/trial.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/planted_option.h"

namespace pickbed::tests {
namespace {

TEST(EvalOptions, ValuesOutOfRangeAreRefused) {
  const auto study = [](const ToleranceOptions& options) {
    PlanStudy(Cube(0.03, 0.05, 0.6), nullptr, {}, options);
  };
  const auto sweep = [](const SweepOptions& options) { RunSweep({}, options, {}); };
  const auto try_trial = [](const TrialOptions& options) {
    TrialRunner(CubeScenario(1), EasyCube(), {}, options);
  };
  const PlantedOption planted[] = {
      {"candidates",
       [] {
         SequentialOptions options;
         options.candidates = -1;
         SequentialStop(0.1, options);
       }},
      {"confidence",
       [] {
         SequentialOptions options;
         options.confidence = 1;
         SequentialStop(0.1, options);
       }},
      {"jobs",
       [&] {
         SweepOptions options;
         options.jobs = 0;
         sweep(options);
       }},
      {"shard.index",
       [&] {
         SweepOptions options;
         options.shard = {3, 2};
         sweep(options);
       }},
      {"retry_radius_m",
       [&] {
         TrialOptions options;
         options.retry_radius_m = kNotANumber;
         try_trial(options);
       }},
      {"cloud_stride_px",
       [&] {
         TrialOptions options;
         options.cloud_stride_px = 0;
         try_trial(options);
       }},
      {"icp_starts",
       [] {
         CropBenchmarkJob job;
         job.options.icp_starts = 0;
         RunCropBenchmark(job);
       }},
      {"methods.wohlhart.pushers",
       [] {
         CropBenchmarkJob job;
         job.options.methods.wohlhart.pushers = 0;
         RunCropBenchmark(job);
       }},
      {"shards",
       [] {
         SlurmJob job;
         job.options.shards = 0;
         JobScript(job);
       }},
      {"cpus",
       [] {
         SlurmJob job;
         job.options.cpus = -1;
         RunOnSlurm({}, job, {});
       }},
      {"step_mm",
       [&] {
         ToleranceOptions options;
         options.step_mm = kNotANumber;
         study(options);
       }},
      {"execute.place.gap_m",
       [&] {
         ToleranceOptions options;
         options.execute.place.gap_m = -1;
         study(options);
       }},
      {"camera.width",
       [] {
         ScenarioSpec spec = CubeScenario(1);
         spec.camera.width = 8;
         SimulatedCell(spec, EasyCube());
       }},
      {"estimator.min_score",
       [] {
         ScenarioSpec spec = CubeScenario(1);
         spec.estimator.min_score = kNotANumber;
         SimulatedCell(spec, EasyCube());
       }},
  };
  ExpectRefused(planted);
}

}  // namespace
}  // namespace pickbed::tests
