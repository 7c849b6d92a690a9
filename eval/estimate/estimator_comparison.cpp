#include "eval/estimate/estimator_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <set>

#include "eval/frames/region.h"
#include "eval/runtime/process.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/attempt_pictures.h"
#include "eval/tolerance/maps.h"
#include "eval/trial/estimator_runner.h"
#include "eval/trial/oracle_estimator.h"
#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/settings_names.h"

namespace pickbed::eval {
namespace {

constexpr double kMebibyte = 1024.0 * 1024.0;

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// State of a row during the comparison.
struct LiveRow {
  std::unique_ptr<EstimatorRunner> runner;  // null: the oracle
  EstimatorSpec spec;
  std::unique_ptr<ScoreAccumulator> evaluator;
  double held_mib = 0;  // memory held after loading
  ComparedRow result;
};

// Ground truth of a bin for the BOP scores.
struct TrueBin {
  ScoredImage image;
  ImageTargets targets;
};

TrueBin TruthFor(const Scene& scene, const Observation& view, const Camera& camera) {
  TrueBin truth{{view.frame.intrinsics, view.frame.depth_m, {}}, {true, true, {}}};
  const Pose X_CW = camera.X_CW();
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const double visible = view.visible_fractions[i];
    truth.image.instances.push_back({posed.object + 1, X_CW * posed.X_WO, visible});
    if (visible >= kCountedVisibility) ++truth.targets.counts[posed.object + 1];
  }
  return truth;
}

void AddToScores(const TrueBin& truth, const std::vector<PoseHypothesis>& hypotheses,
                 ScoreAccumulator& evaluator) {
  std::vector<DatasetEstimate> estimates;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    DatasetEstimate& estimate = estimates.emplace_back();
    estimate.object_id = hypothesis.object + 1;
    estimate.score = hypothesis.score;
    estimate.X_CO = hypothesis.X_CO;
  }
  std::vector<const DatasetEstimate*> pointers;
  for (const DatasetEstimate& estimate : estimates) pointers.push_back(&estimate);
  evaluator.AddImage(truth.image, truth.targets, pointers);
}

std::string FolderName(std::string label) {
  for (const char separator : {':', '=', '/'}) {
    std::replace(label.begin(), label.end(), separator, '_');
  }
  return label;
}

// Parses a label such as "kehl:accurate=kehl.net": name, mode and model file.
EstimatorSpec Labelled(const std::string& label, const EstimatorSpec& base) {
  const size_t equals = label.find('=');
  const std::string method = label.substr(0, equals);
  const size_t colon = method.find(':');
  EstimatorSpec spec = base;
  spec.name = method.substr(0, colon);
  if (colon != std::string::npos) spec.mode = method.substr(colon + 1);
  if (spec.name != base.name) {  // these belong to one estimator
    spec.model.clear();
    spec.calibration.clear();
    spec.scores = EstimatorSpec().scores;
  }
  if (equals != std::string::npos) {
    spec.model = label.substr(equals + 1);
    CheckInput(!spec.model.empty(), fmt::format("estimator '{}' has no model after '='", label));
  }
  RequireEstimator(spec.name);
  return spec;
}

// Returns the settings of the scenario with the estimator in place of its own.
ScenarioSpec SettingsWith(const ScenarioSpec& scenario, const ComparedEstimator& estimator) {
  ScenarioSpec spec = scenario;
  const bool is_named = estimator.spec.name != spec.estimator.name ||
                        estimator.spec.mode != spec.estimator.mode ||
                        estimator.spec.model != spec.estimator.model;
  if (is_named) spec.places["estimator"] = "--estimator " + estimator.label;
  spec.estimator = estimator.spec;
  return spec;
}

class Comparison {
 public:
  explicit Comparison(const ComparisonJob& job) : job_(job), cell_(job.spec, job.objects) {
    for (const auto& model : cell_.objects()) metrics_.push_back(MakeMetricModel(*model));
    for (const ComparedEstimator& estimator : job.estimators) rows_.push_back(Load(estimator));
  }

  void LookAt(BinIndex bin_index) {
    const Scene scene = cell_.MakeScene(bin_index).scene;
    if (scene.objects.empty()) return;
    const Observation view = cell_.Capture(scene, bin_index, 0);
    const TrueBin truth = TruthFor(scene, view, cell_.camera());
    const InstanceMatcher matcher(
        metrics_, InstancesOf(scene, view.visible_fractions, cell_.camera().X_CW()));
    for (LiveRow& row : rows_) {
      // Only before the first image. Getting the pages back from the system costs time, and the
      // first image takes longer than the others anyway.
      if (row.result.images.empty()) ReleaseFreedMemory();
      const size_t before = ResetPeakMemory();
      Rng rng = Rng::Derive(job_.spec.seed, bin_index, "estimate/0");
      EstimateResult found =
          row.runner ? row.runner->Estimate(view.frame, view.calibration, rng, nullptr, {},
                                            bin_index == BinIndex(0))
                     : OracleEstimate(InstancesInImage(cell_, bin_index, matcher.instances()),
                                      row.spec, rng);
      Grow(row, before);
      if (found.failure) Warn(bin_index, *found.failure);
      AddToScores(truth, found.hypotheses, *row.evaluator);
      row.result.images.push_back(
          {bin_index,
           ScoreAgainstTruth(matcher, cell_.camera(), view.calibration.camera.X_WC(),
                             found.hypotheses),
           std::move(found.seconds)});
    }
    if (!HasPictures(bin_index)) return;
    for (const LiveRow& row : rows_) Draw(row, bin_index, scene, view);
  }

  std::vector<ComparedRow> Finish() {
    std::vector<ComparedRow> done;
    for (LiveRow& row : rows_) {
      row.evaluator->Finish(row.result.bop);
      done.push_back(std::move(row.result));
    }
    return done;
  }

 private:
  void Warn(BinIndex bin_index, const EstimatorFailure& failure) const {
    if (!job_.on_warning) return;
    job_.on_warning(fmt::format("bin {}: {}", bin_index, failure.text));
    for (const std::string& line : failure.traceback) job_.on_warning("  " + line);
  }

  LiveRow Load(const ComparedEstimator& estimator) {
    LiveRow row;
    row.result.label = estimator.label;
    const ScenarioSpec spec = SettingsWith(job_.spec, estimator);
    ReleaseFreedMemory();
    const size_t before = ResetPeakMemory();
    const auto start = Clock::now();
    row.spec = estimator.spec;
    const auto on_progress = [&](std::string_view what, double share) {
      if (job_.on_progress) job_.on_progress(what, static_cast<int>(100 * share), 100);
    };
    row.runner = MakeEstimatorRunner(cell_, spec, job_.threads, on_progress,
                                     job_.out.empty() ? "" : job_.out / kLogsFolder);
    row.result.setup_s = SecondsSince(start);
    Grow(row, before);
    ReleaseFreedMemory();
    const size_t held = ResetPeakMemory();
    row.held_mib = held > before ? static_cast<double>(held - before) / kMebibyte : 0;
    row.evaluator = std::make_unique<ScoreAccumulator>(
        [this](int object_id) { return cell_.objects()[object_id - 1]; });
    return row;
  }

  // Updates the peak: memory held after loading plus the growth above `before` (bytes).
  static void Grow(LiveRow& row, size_t before) {
    const size_t peak = PeakMemory();
    const double grown_mib = peak > before ? static_cast<double>(peak - before) / kMebibyte : 0;
    row.result.peak_memory_mib = std::max(row.result.peak_memory_mib, row.held_mib + grown_mib);
  }

  // Returns whether the last bin gets pictures.
  bool HasPictures(int trial) const {
    if (job_.out.empty()) return false;
    if (trial < job_.pictured_bins) return true;
    if (!job_.wants_pictures) return false;
    std::vector<const ComparedImage*> images;
    for (const LiveRow& row : rows_) images.push_back(&row.result.images.back());
    return job_.wants_pictures(images);
  }

  // Draws the last image of a row.
  void Draw(const LiveRow& row, int trial, const Scene& scene, const Observation& view) {
    const sim::Picture& picture = pictures_.Of(cell_, scene, BinIndex(trial));
    const AttemptScore& score = row.result.images.back().score;
    OverlayInput input{picture.color, picture.camera.intrinsics, cell_.objects(),
                       OverlayPoses(score.hypotheses)};
    input.ids = &picture.ids;
    input.missed = MissedInstances(score.instances);
    Image<uint8_t> region_pixels;
    if (const RegionSpec& roi = job_.spec.roi; !roi.empty()) {
      const ImageRegion region =
          MakeRegion(roi, view.frame, picture.camera.X_CW(), cell_.objects());
      region_pixels = RegionInPicture(region, view.frame.intrinsics, picture.camera.intrinsics);
      input.region = &region_pixels;
      input.region_lines = region.BoxLines(picture.camera.intrinsics);
    }
    WriteAttemptPictures(ComparedOverlay(job_.out, trial, row.result.label).parent_path(), 0,
                         view.frame, DrawOverlay(input));
  }

  const ComparisonJob& job_;
  SimulatedCell cell_;
  std::vector<MetricModel> metrics_;
  std::vector<LiveRow> rows_;
  BinPictures pictures_;
};

}  // namespace

std::string CurrentLabel(const std::string& label) {
  const size_t colon = label.find(':'), equals = label.find('=');
  if (colon == std::string::npos || colon > equals) return label;
  EstimatorSpec spec;
  constexpr std::string_view kKey = "mode=";
  const CurrentText mode =
      AssignmentWithCurrentNames(std::string(kKey) + label.substr(colon + 1, equals - colon - 1),
                                 [&](SettingsVisitor& v) { spec.Visit(v); });
  if (mode.replaced.empty()) return label;
  const std::string current = label.substr(0, colon + 1) + mode.text.substr(kKey.size()) +
                              (equals == std::string::npos ? "" : label.substr(equals));
  ReportDeprecation(fmt::format("estimator '{}' is deprecated, write '{}'", label, current));
  return current;
}

std::vector<ComparedEstimator> ParseEstimators(const std::vector<std::string>& labels,
                                               const EstimatorSpec& base) {
  std::vector<ComparedEstimator> rows;
  std::set<std::string> seen;
  for (const std::string& given : labels) {
    const std::string label = CurrentLabel(given);
    CheckInput(seen.insert(label).second, fmt::format("estimator '{}' is named twice", label));
    rows.push_back({label, Labelled(label, base)});
  }
  return rows;
}

void RequireModes(const ScenarioSpec& scenario, const std::vector<ComparedEstimator>& estimators) {
  for (const ComparedEstimator& estimator : estimators) {
    if (estimator.spec.name == kOracleName) continue;
    const ScenarioSpec spec = SettingsWith(scenario, estimator);
    WithSettingsKey(spec, "estimator", [&] { RequireMode(spec.estimator); });
  }
}

std::vector<ComparedRow> CompareEstimators(const ComparisonJob& job) {
  Comparison comparison(job);
  for (int trial = 0; trial < job.spec.trials; ++trial) {
    if (job.stop && job.stop()) break;
    comparison.LookAt(BinIndex(trial));
    if (job.on_progress) job.on_progress("bin", trial + 1, job.spec.trials);
  }
  return comparison.Finish();
}

std::filesystem::path ComparedOverlay(const std::filesystem::path& out, int trial,
                                      const std::string& label) {
  return PicturesOf(out, trial) / FolderName(label) / AttemptPicture(0, "overlay");
}

void AddPickChances(const ToleranceMaps& maps, std::vector<ComparedRow>& rows) {
  for (ComparedRow& row : rows) {
    for (ComparedImage& image : row.images) {
      image.pick_chances.clear();
      for (const ScoredHypothesis& h : image.score.hypotheses) {
        image.pick_chances.push_back(maps.PickChance(h.record));
      }
    }
  }
}

}  // namespace pickbed::eval
