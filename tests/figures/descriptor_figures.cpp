// Measurements of the learned estimator that need more than its results, on validation bins (seed
// 500), printed to stdout:
//   descriptor_figures icp BINS SCENARIO...         instances lost by refinement from the true pose
//   descriptor_figures index BINS SCENARIO...       recall and seconds of the search in the code
//                                                   book, compared with an exact search
//   descriptor_figures ambiguous BINS SCENARIO...   instances whose image does not determine
//                                                   the pose: another pose gives the same image
//   descriptor_figures outcomes BINS SCENARIO...    failing stages of mode accurate, by visible
//                                                   fraction
//   descriptor_figures candidates BINS SCENARIO...  CSV of the verifier's inputs in mode accurate:
//                                                   scenario, bin, nearest instance and its visible
//                                                   fraction, error in diameters, score, features
// KEY=VALUE among the scenarios is a setting of all following scenarios.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/cell/simulated_cell.h"
#include "eval/estimate/statistics.h"
#include "eval/explain/truth.h"
#include "eval/trial/estimator_runner.h"
#include "perception/estimators/descriptor.h"
#include "perception/icp/pcl_icp.h"
#include "perception/icp/projective_icp.h"
#include "perception/model/ambiguous_poses.h"
#include "scenes/base/files.h"
#include "scenes/scenario/find_scenario.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr uint64_t kValidationSeed = 500;
constexpr double kRight = 0.1;  // maximum error of a correct pose, in diameters

struct Bins {
  std::string scenario;
  std::vector<std::string> settings;
  int count = 0;
};

LoadedScenario Load(const Bins& bins) {
  ScenarioRequest arguments;
  arguments.scenario = bins.scenario;
  arguments.settings = bins.settings;
  LoadedScenario loaded = FindScenario(arguments);
  loaded.spec.seed = kValidationSeed;
  return loaded;
}

void ForEachBin(SimulatedCell& cell, int bins,
                const std::function<void(const Scene&, const Observation&)>& visit) {
  for (int trial = 0; trial < bins; ++trial) {
    const Scene scene = cell.MakeScene(BinIndex(trial)).scene;
    visit(scene, cell.Capture(scene, BinIndex(trial), 0));
  }
}

KnownBackground BackgroundOf(const SimulatedCell& cell) {
  return {cell.bin(), cell.camera().X_CW()};
}

// Runs both refiners from the true pose of each instance that is clearly visible. The estimator
// also tries half of the first correspondence distance and keeps the better result, so it loses no
// more.
void MeasureIcp(const Bins& bins) {
  constexpr double kClear = 0.5;  // visible fraction
  const LoadedScenario loaded = Load(bins);
  SimulatedCell cell(loaded.spec, loaded.objects);
  const CandidateRefinementOptions options = OptionsForMode("accurate").candidates;
  std::vector<ModelPoints> models;
  std::vector<PoseDistance> distances;
  for (const auto& object : cell.objects()) {
    models.push_back(MakeModelPoints(*object));
    distances.emplace_back(*object);
  }
  int clear = 0, wrong_after_icp = 0, wrong_after_refiner = 0;
  std::vector<double> errors;
  ForEachBin(cell, bins.count, [&](const Scene& scene, const Observation& view) {
    const OrganizedCloud cloud = BuildCloud(view.frame, BackgroundOf(cell));
    const PclIcp refiner(cloud);
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      if (view.visible_fractions[i] < kClear) continue;
      const ObjectId object = scene.objects[i].object;
      const Pose truth = cell.camera().X_CW() * scene.objects[i].X_WO;
      ProjectiveIcpOptions icp = options.icp;
      icp.max_correspondence_distance_m = std::max(
          icp.final_correspondence_distance_m,
          std::clamp(options.correspondence_distance_diameters * models[object].diameter_m,
                     options.min_correspondence_distance_m, options.max_correspondence_distance_m));
      const Pose refined = ProjectiveIcp(cloud, models[object], truth, icp).X_CO;
      ++clear;
      wrong_after_icp += distances[object](refined, truth) >= kRight;
      errors.push_back(distances[object](refiner.Refine(models[object], refined).X_CO, truth));
      wrong_after_refiner += errors.back() >= kRight;
    }
  });
  if (errors.empty()) return;
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  fmt::print(
      "{:<14} {:>6} clear instances; wrong after ICP {:>3} ({:.1f} %), wrong after the final "
      "refiner {:>3} ({:.1f} %), ",
      bins.scenario, clear, wrong_after_icp, 100.0 * wrong_after_icp / clear, wrong_after_refiner,
      100.0 * wrong_after_refiner / clear);
  fmt::print("median error {:.4f} diameters\n", errors[errors.size() / 2]);
}

// Returns the fraction of the instance's pixels whose depth would change by more than noise if the
// pose were X_WO * S_O. Newly covered pixels count too.
double ChangedShare(SceneRenderer& renderer, const Camera& camera, const Scene& scene, size_t i,
                    const Pose& S_O, const RenderedImage& before) {
  constexpr float kNoise_m = 0.003f;
  const uint16_t id = static_cast<uint16_t>(scene.objects[i].instance + 1);
  Scene rotated = scene;
  rotated.objects[i].X_WO = rotated.objects[i].X_WO * S_O;
  RenderOutputs outputs;
  outputs.color = false;
  const RenderedImage after = renderer.Render(rotated, camera, {}, outputs);
  int seen = 0, changed = 0;
  for (size_t p = 0; p < before.ids.size(); ++p) {
    const bool was = before.ids.data()[p] == id;
    seen += was;
    if (!was && after.ids.data()[p] != id) continue;
    changed += std::abs(before.depth_m.data()[p] - after.depth_m.data()[p]) > kNoise_m;
  }
  return static_cast<double>(changed) / std::max(1, seen);
}

void CountAmbiguous(const Bins& bins) {
  constexpr double kSeen = 0.1;  // visible fraction from which an instance counts
  constexpr std::array<double, 3> kShares{0.01, 0.02, 0.05};
  const LoadedScenario loaded = Load(bins);
  SimulatedCell cell(loaded.spec, loaded.objects);
  SceneRenderer renderer(cell.objects(), cell.bin());
  std::vector<std::vector<Pose>> ambiguous_poses;
  for (const auto& object : cell.objects()) {
    const PoseDistance distance(*object);
    ambiguous_poses.push_back(AmbiguousPoses(*object, MakeModelPoints(*object), distance));
  }
  int instances = 0;
  std::array<int, kShares.size()> ambiguous{};
  ForEachBin(cell, bins.count, [&](const Scene& scene, const Observation& view) {
    RenderOutputs outputs;
    outputs.color = false;
    const RenderedImage before = renderer.Render(scene, cell.camera(), {}, outputs);
    for (size_t i = 0; i < scene.objects.size(); ++i) {
      if (view.visible_fractions[i] < kSeen) continue;
      ++instances;
      double min_share = 1;
      for (const Pose& S_O : ambiguous_poses[scene.objects[i].object]) {
        min_share =
            std::min(min_share, ChangedShare(renderer, cell.camera(), scene, i, S_O, before));
      }
      for (size_t k = 0; k < kShares.size(); ++k) ambiguous[k] += min_share < kShares[k];
    }
  });
  fmt::print("{:<14} {:>6} instances; share with another pose that changes less than",
             bins.scenario, instances);
  for (size_t k = 0; k < kShares.size(); ++k) {
    fmt::print("{} {:.0f} % of the pixels of {:.1f} %", k > 0 ? "," : "", 100 * kShares[k],
               100.0 * ambiguous[k] / std::max(1, instances));
  }
  fmt::print("\n");
}

struct IndexResult {
  double recall_at_95 = 0, seconds = 0;
};

IndexResult MeasureIndex(const LoadedScenario& loaded, int bins, bool exact) {
  SimulatedCell cell(loaded.spec, loaded.objects);
  const auto views = CellViews(cell, cell.objects());
  EstimatorSetup setup;
  setup.objects = cell.objects();
  setup.spec = loaded.spec.estimator;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = WorkingDistance_m(cell);
  setup.refiner = loaded.spec.refiner;
  setup.views = views.get();
  setup.cache_dir = CacheDir();
  DescriptorOptions options = OptionsForMode(loaded.spec.estimator.mode);
  options.candidates.min_points = options.candidates.points;
  if (exact) options.candidates.index.linear_below = NeighborOptions::kAlwaysLinear;
  const auto estimator = MakeDescriptorEstimator(setup, options);
  std::vector<MetricModel> metrics;
  for (const auto& model : cell.objects()) metrics.push_back(MakeMetricModel(*model));
  ComparedRow row;
  ForEachBin(cell, bins, [&](const Scene& scene, const Observation& view) {
    Rng rng(0);
    EstimateResult found = estimator->Estimate({view.frame, BackgroundOf(cell)}, rng);
    row.images.push_back({static_cast<int>(row.images.size()),
                          ScoreAgainstTruth({metrics, InstancesOf(scene, view.visible_fractions,
                                                                  cell.camera().X_CW())},
                                            cell.camera(), found.hypotheses),
                          std::move(found.seconds)});
  });
  const ComparisonStatistics statistics = StatisticsOf(row);
  return {statistics.recall_at_95, statistics.stages.at("neighbors")};
}

void CompareIndex(const Bins& bins) {
  LoadedScenario loaded = Load(bins);
  loaded.spec.estimator.mode = "fast";  // 600 queries per object
  const IndexResult index = MeasureIndex(loaded, bins.count, false);
  const IndexResult exact = MeasureIndex(loaded, bins.count, true);
  fmt::print("{:<14} recall {:.3f}, exact {:.3f}; {:.1f} ms per image, exact {:.1f}\n",
             bins.scenario, index.recall_at_95, exact.recall_at_95, 1e3 * index.seconds,
             1e3 * exact.seconds);
}

// Counts the failing stages of the instances, by band of visible fraction.
void CountOutcomes(const Bins& bins) {
  constexpr std::array<double, 6> kBands{0.1, 0.3, 0.5, 0.7, 0.9, 1.01};
  LoadedScenario loaded = Load(bins);
  loaded.spec.estimator.mode = "accurate";
  SimulatedCell cell(loaded.spec, loaded.objects);
  EstimatorRunner runner(cell, loaded.spec, 2, {});
  std::vector<ModelPoints> models;
  for (const auto& object : cell.objects()) models.push_back(MakeModelPoints(*object));
  const Pose X_CW = cell.camera().X_CW();
  std::array<std::map<FailingStage, int>, kBands.size() - 1> counts;
  ForEachBin(cell, bins.count, [&](const Scene& scene, const Observation& view) {
    const PoseJudge judge(cell.objects(), InstancesOf(scene, view.visible_fractions, X_CW));
    EstimateTrace trace;
    Rng rng(0);
    const EstimateResult result = runner.Estimate(view.frame, rng, &trace);
    std::vector<InstanceMatch> errors;
    for (const TracedVote& vote : trace.votes) {
      errors.push_back(judge(vote.vote.object, vote.vote.X_CO));
    }
    const auto outcomes = DiagnoseInstances(judge, trace, errors, models, result.hypotheses);
    for (size_t i = 0; i < outcomes.size(); ++i) {
      for (size_t band = 0; band + 1 < kBands.size(); ++band) {
        const double visible = judge.instances()[i].visible_fraction;
        counts[band][outcomes[i].failing_stage] +=
            visible >= kBands[band] && visible < kBands[band + 1];
      }
    }
  });
  for (size_t band = kBands.size() - 1; band-- > 0;) {
    fmt::print("{:<14} {:>3.0f} to {:>3.0f} %:", bins.scenario, 100 * kBands[band],
               100 * std::min(1.0, kBands[band + 1]));
    for (const auto& [stage, count] : counts[band]) {
      if (count > 0) fmt::print("  {} {}", TextOf(stage).name, count);
    }
    fmt::print("\n");
  }
}

void WriteCandidates(const Bins& bins) {
  LoadedScenario loaded = Load(bins);
  loaded.spec.estimator.mode = "accurate";
  SimulatedCell cell(loaded.spec, loaded.objects);
  EstimatorRunner runner(cell, loaded.spec, 2, {});
  const Pose X_CW = cell.camera().X_CW();
  int bin = 0;
  ForEachBin(cell, bins.count, [&](const Scene& scene, const Observation& view) {
    const PoseJudge judge(cell.objects(), InstancesOf(scene, view.visible_fractions, X_CW));
    EstimateTrace trace;
    Rng rng(0);
    runner.Estimate(view.frame, rng, &trace);
    for (const TracedCandidate& candidate : trace.candidates) {
      const PoseHypothesis& pose = candidate.hypothesis;
      const InstanceMatch match = judge(pose.object, pose.X_CO);
      const double visible =
          match.position < 0 ? 0 : judge.instances()[match.position].visible_fraction;
      fmt::print("{},{},{},{:.3f},{:.4f},{:.4f}", bins.scenario, bin, match.position, visible,
                 match.mssd_diameters, pose.score);
      for (const float feature : candidate.features) fmt::print(",{:.5g}", feature);
      fmt::print("\n");
    }
    ++bin;
  });
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  const std::map<std::string, void (*)(const pickbed::tests::Bins&)> modes = {
      {"ambiguous", pickbed::tests::CountAmbiguous},
      {"candidates", pickbed::tests::WriteCandidates},
      {"outcomes", pickbed::tests::CountOutcomes},
      {"icp", pickbed::tests::MeasureIcp},
      {"index", pickbed::tests::CompareIndex}};
  const auto mode = argc > 3 ? modes.find(argv[1]) : modes.end();
  if (mode == modes.end() || std::atoi(argv[2]) < 1) {
    fmt::print(stderr,
               "descriptor_figures ambiguous|candidates|outcomes|icp|index BINS [KEY=VALUE] "
               "SCENARIO...\n");
    return 1;
  }
  pickbed::tests::Bins bins;
  bins.count = std::atoi(argv[2]);
  for (int i = 3; i < argc; ++i) {
    bins.scenario = argv[i];
    if (bins.scenario.find('=') != std::string::npos) {
      bins.settings.push_back(bins.scenario);
      continue;
    }
    mode->second(bins);
    std::fflush(stdout);
  }
  return 0;
}
