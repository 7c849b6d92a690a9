// Grid search with which the two modes of point pair features were tuned, on validation bins (seed
// 500), printed to stdout:
//   ppf_figures plain BINS PART...      recall at precision 0.95 of ppf
//   ppf_figures verified BINS PART...   recall of the candidates of ppf:verified, before a verifier

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "eval/cell/simulated_cell.h"
#include "eval/estimate/statistics.h"
#include "perception/estimators/ppf.h"
#include "perception/estimators/ppf_verified.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr uint64_t kValidationSeed = 500;

struct CapturedBin {
  std::vector<TrueInstance> instances;
  Observation view;
};

EstimateResult Plain(const SimulatedCell& cell, const Observation& view,
                     const PpfMatchOptions& match) {
  EstimatorSetup setup;
  setup.objects = cell.objects();
  setup.spec.min_score = 0.1;  // the threshold is determined from the results
  PpfOptions options;
  options.match.model_sampling = match.model_sampling;
  options.match.scene_voxel_diameters = match.scene_voxel_diameters;
  options.match.scene_step = match.scene_step;
  const KnownBackground background{cell.bin(), cell.camera().X_CW()};
  Rng rng(0);
  return MakePpfEstimator(setup, options)->Estimate({view.frame, background}, rng);
}

EstimateResult Candidates(const SimulatedCell& cell, const Observation& view,
                          const PpfMatchOptions& match) {
  VerifiedPpfOptions options;
  options.match = match;
  const KnownBackground background{cell.bin(), cell.camera().X_CW()};
  Rng rng(0);
  EstimateResult result;
  const auto source = MakePpfCandidates(cell.objects(), options);
  for (const Candidate& candidate :
       source->Find(BuildCloud(view.frame, background), rng, result.seconds)) {
    result.hypotheses.push_back(candidate.hypothesis);
  }
  return result;
}

void Measure(bool verified, int bins, const std::string& object,
             const std::vector<PpfMatchOptions>& grid) {
  ScenarioRequest arguments;
  arguments.scenario = "bin_" + object;
  LoadedScenario loaded = FindScenario(arguments);
  loaded.spec.seed = kValidationSeed;
  SimulatedCell cell(loaded.spec, loaded.objects);
  std::vector<MetricModel> metrics;
  for (const auto& model : cell.objects()) metrics.push_back(MakeMetricModel(*model));
  std::vector<CapturedBin> captured;
  for (int trial = 0; trial < bins; ++trial) {
    Scene scene = cell.MakeScene(BinIndex(trial)).scene;
    Observation view = cell.Capture(scene, BinIndex(trial), 0);
    captured.push_back(
        {InstancesOf(scene, view.visible_fractions, cell.camera().X_CW()), std::move(view)});
  }
  for (const PpfMatchOptions& match : grid) {
    ComparedRow row;
    for (const CapturedBin& bin : captured) {
      EstimateResult found =
          verified ? Candidates(cell, bin.view, match) : Plain(cell, bin.view, match);
      row.images.push_back(
          {static_cast<int>(row.images.size()),
           ScoreAgainstTruth({metrics, bin.instances}, cell.camera(), found.hypotheses),
           std::move(found.seconds)});
    }
    const ComparisonStatistics statistics = StatisticsOf(row);
    double seconds = 0;
    for (const auto& [stage, value] : statistics.stages) seconds += value;
    fmt::print("{:<10} {:5.2f} {:5.2f} {:5.2f} {:5.1f} {:7.3f} {:7.1f} {:7.1f}\n", object,
               match.model_sampling, match.scene_voxel_diameters, match.scene_step,
               match.window_diameters, verified ? statistics.recall() : statistics.recall_at_95,
               statistics.stages.count("match") ? statistics.stages.at("match") : 0.0, seconds);
    std::fflush(stdout);
  }
}

std::vector<PpfMatchOptions> Grid(double window_diameters) {
  std::vector<PpfMatchOptions> grid;
  for (const double model_sampling : {0.07, 0.1}) {
    for (const double voxel : {0.04, 0.06, 0.08}) {
      for (const double step : {0.1, 0.2}) {
        PpfMatchOptions match = VerifiedPpfOptions().match;
        match.model_sampling = model_sampling;
        match.scene_voxel_diameters = voxel;
        match.scene_step = step;
        match.window_diameters = window_diameters;
        grid.push_back(match);
      }
    }
  }
  return grid;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  const std::string mode = argc > 3 ? argv[1] : "";
  if (mode != "plain" && mode != "verified") {
    fmt::print(stderr, "ppf_figures plain|verified BINS PART...\n");
    return 1;
  }
  const bool verified = mode == "verified";
  fmt::print("{:<10} {:>5} {:>5} {:>5} {:>5} {:>7} {:>7} {:>7}\n", "part", "model", "voxel", "step",
             "wind", "recall", "match_s", "all_s");
  for (int i = 3; i < argc; ++i) {
    pickbed::tests::Measure(
        verified, std::atoi(argv[2]), argv[i],
        pickbed::tests::Grid(
            verified ? pickbed::perception::VerifiedPpfOptions().match.window_diameters : 0));
  }
  return 0;
}
