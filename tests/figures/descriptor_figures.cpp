// Figures of the learned estimator that need more than its results, on validation bins (seed 500),
// on stdout:
//   descriptor_figures icp BINS SCENARIO...     instances that refinement loses from the true pose
//   descriptor_figures index BINS SCENARIO...   recall and seconds of the search in the code book,
//                                               beside those of an exact one

#include <fmt/format.h>

#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/command_line.h"
#include "eval/comparison_figures.h"
#include "eval/estimator_runner.h"
#include "eval/oracle.h"
#include "eval/virtual_cell.h"
#include "perception/estimators/descriptor.h"
#include "perception/icp.h"
#include "perception/projective_icp.h"
#include "scenes/files.h"

namespace pickbed {
namespace {

constexpr uint64_t kValidationSeed = 500;
constexpr double kRight = 0.1;  // diameters

LoadedScenario Load(const std::string& scenario) {
  ScenarioArguments arguments;
  arguments.scenario = scenario;
  LoadedScenario loaded = LoadScenarioArguments(arguments);
  loaded.spec.seed = kValidationSeed;
  return loaded;
}

void ForEachBin(VirtualCell& cell, int bins,
                const std::function<void(const Scene&, const View&)>& look) {
  for (int trial = 0; trial < bins; ++trial) {
    const Scene scene = cell.MakeScene(trial).scene;
    look(scene, cell.See(scene, trial, 0));
  }
}

KnownBackground BackgroundOf(const VirtualCell& cell) {
  return {cell.bin(), cell.camera().X_WC.inverse()};
}

// Both refiners, started at the true pose of each clear instance. The estimator also tries half the
// first gate and keeps the better of the two, so that it loses no more.
void MeasureIcp(const std::string& scenario, int bins) {
  constexpr double kClear = 0.5;  // visible fraction
  const LoadedScenario loaded = Load(scenario);
  VirtualCell cell(loaded.spec, loaded.objects);
  const AssessmentOptions options = OptionsForMode("hard").candidates;
  std::vector<ModelPoints> models;
  std::vector<PoseDistance> distances;
  for (const auto& object : cell.objects()) {
    models.push_back(MakeModelPoints(*object));
    distances.emplace_back(*object);
  }
  int clear = 0, lost_in_bulk = 0, lost_at_last = 0;
  std::vector<double> errors;
  ForEachBin(cell, bins, [&](const Scene& scene, const View& view) {
    const OrganizedCloud cloud = BuildCloud(view.frame, BackgroundOf(cell));
    const PclRefiner refiner(cloud);
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      if (view.visible_fractions[i] < kClear) continue;
      const int part = scene.objects[i].object;
      const Pose truth = cell.camera().X_WC.inverse() * scene.objects[i].X_WO;
      ProjectiveIcpOptions icp = options.icp;
      icp.gate_m =
          std::max(icp.gate_end_m, std::clamp(options.gate_diameters * models[part].diameter_m,
                                              options.gate_min_m, options.gate_max_m));
      PoseHypothesis pose;
      pose.object = part;
      pose.X_CO = ProjectiveIcp(cloud, models[part], truth, icp).X_CO;
      ++clear;
      lost_in_bulk += distances[part](pose.X_CO, truth) >= kRight;
      refiner.Refine(models[part], pose);
      errors.push_back(distances[part](pose.X_CO, truth));
      lost_at_last += errors.back() >= kRight;
    }
  });
  if (errors.empty()) return;
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  fmt::print("{:<14} {:>6} clear, lost in bulk {:>3} ({:.1f} %), lost at last {:>3} ({:.1f} %), ",
             scenario, clear, lost_in_bulk, 100.0 * lost_in_bulk / clear, lost_at_last,
             100.0 * lost_at_last / clear);
  fmt::print("median {:.4f} diameters off\n", errors[errors.size() / 2]);
}

struct IndexFigures {
  double recall_at_95 = 0, seconds = 0;
};

IndexFigures MeasureIndex(const LoadedScenario& loaded, int bins, bool exact) {
  VirtualCell cell(loaded.spec, loaded.objects);
  const auto views = CellViews(cell, cell.objects());
  EstimatorSetup setup;
  setup.objects = cell.objects();
  setup.spec = loaded.spec.estimator;
  setup.intrinsics = cell.camera().intrinsics;
  ScenarioSpec no_estimator = loaded.spec;
  no_estimator.estimator.name = kOracleName;
  setup.working_distance_m = EstimatorRunner(cell, no_estimator, 1, {}).working_distance_m();
  setup.refiner = loaded.spec.refiner;
  setup.views = views.get();
  setup.cache_dir = CacheDir();
  DescriptorOptions options = OptionsForMode(loaded.spec.estimator.mode);
  options.candidates.min_points = options.candidates.points;
  if (exact) options.candidates.index.linear_below = INT_MAX;
  const auto estimator = MakeDescriptorEstimator(setup, options);
  std::vector<MetricModel> metrics;
  for (const auto& model : cell.objects()) metrics.push_back(MakeMetricModel(*model));
  ComparedRow row;
  ForEachBin(cell, bins, [&](const Scene& scene, const View& view) {
    Rng rng(0);
    EstimateResult found = estimator->Estimate({view.frame, BackgroundOf(cell)}, rng);
    row.looks.push_back(
        {static_cast<int>(row.looks.size()),
         ScoreLook(scene, view.visible_fractions, metrics, cell.camera(), found.hypotheses),
         std::move(found.seconds)});
  });
  const ComparisonFigures figures = FiguresOf(row);
  return {figures.recall_at_95, figures.stages.at("neighbors")};
}

void CompareIndex(const std::string& scenario, int bins) {
  LoadedScenario loaded = Load(scenario);
  loaded.spec.estimator.mode = "fast";  // 600 queries of each part
  const IndexFigures index = MeasureIndex(loaded, bins, false);
  const IndexFigures exact = MeasureIndex(loaded, bins, true);
  fmt::print("{:<14} recall {:.3f}, exact {:.3f}; {:.1f} ms an image, exact {:.1f}\n", scenario,
             index.recall_at_95, exact.recall_at_95, 1e3 * index.seconds, 1e3 * exact.seconds);
}

}  // namespace
}  // namespace pickbed

int main(int argc, char** argv) {
  const std::map<std::string, void (*)(const std::string&, int)> modes = {
      {"icp", pickbed::MeasureIcp}, {"index", pickbed::CompareIndex}};
  const auto mode = argc > 3 ? modes.find(argv[1]) : modes.end();
  if (mode == modes.end() || std::atoi(argv[2]) < 1) {
    fmt::print(stderr, "descriptor_figures icp|index BINS SCENARIO...\n");
    return 1;
  }
  for (int i = 3; i < argc; ++i) {
    mode->second(argv[i], std::atoi(argv[2]));
    std::fflush(stdout);
  }
  return 0;
}
