#include <gtest/gtest.h>

#include "eval/benchmark/crops.h"
#include "eval/sweep/slurm.h"
#include "eval/tolerance/samples.h"
#include "eval/trial/simulated_cell.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/planted_option.h"

namespace pickbed::tests {
namespace {

TEST(EvalOptions, ValuesOutOfRangeAreRefused) {
  const auto study = [](const ToleranceOptions& options) {
    PlanStudy(Cube(0.03, 0.05, 0.6), nullptr, {}, options);
  };
  const PlantedOption planted[] = {
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
