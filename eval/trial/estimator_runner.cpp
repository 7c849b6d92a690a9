#include "eval/trial/estimator_runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/cell/visible_size.h"
#include "eval/frames/region.h"
#include "eval/trial/oracle_estimator.h"
#include "eval/trial/timed_stages.h"
#include "perception/candidates/estimate_trace.h"
#include "perception/estimators/finite_poses.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/finite_counts.h"
#include "sim/training_view_source.h"

namespace pickbed::eval {
namespace {

// Replaces the object indices of the estimator by the indices into cell.objects().
void Renumber(const std::vector<ObjectId>& wanted, EstimateTrace& trace) {
  for (TracedVote& vote : trace.votes) vote.vote.object = wanted[vote.vote.object];
  for (TracedRefinement& refinement : trace.refinements) {
    refinement.before.object = refinement.after.object = wanted[refinement.before.object];
  }
  for (TracedCandidate& candidate : trace.candidates) {
    candidate.hypothesis.object = wanted[candidate.hypothesis.object];
  }
  for (PoseHypothesis& accepted : trace.accepted) accepted.object = wanted[accepted.object];
}

void RequireNames(const ScenarioSpec& spec) {
  WithSettingsKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  WithSettingsKey(spec, "refiner", [&] { RefinerNamed(spec.refiner); });
}

}  // namespace

std::unique_ptr<LabelledViewSource> CellViews(const SimulatedCell& cell, const ObjectSet& objects) {
  ViewSourceOptions options;
  options.sensor = cell.sensor();
  options.camera = cell.camera().intrinsics;
  options.bin = cell.bin();
  return MakeSimViewSource(objects, options);
}

void RemoveOutsideBin(const SimulatedCell& cell, const CellCalibration& calibration,
                      std::vector<PoseHypothesis>& hypotheses) {
  const Pose X_BC = calibration.X_BD();
  std::erase_if(hypotheses, [&](const PoseHypothesis& hypothesis) {
    const Eigen::Vector3d& com_O = cell.objects()[hypothesis.object]->mass.com_O;
    return !cell.bin().Holds(X_BC * hypothesis.X_CO * com_O);
  });
}

double WorkingDistance_m(const SimulatedCell& cell) {
  return WorkingDistance_m(cell.camera(), cell.bin().inner_size_m.z());
}

EstimatorRunner::EstimatorRunner(const SimulatedCell& cell, const ScenarioSpec& spec, int threads,
                                 const Progress& on_progress, const std::filesystem::path& log_dir)
    : cell_(cell), roi_(spec.roi) {
  RequireNames(spec);
  EstimatorSetup setup;
  for (const ObjectId object : cell.wanted()) setup.objects.push_back(cell.objects()[object]);
  setup.spec = spec.estimator;
  setup.refiner = spec.refiner;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = WorkingDistance_m(cell);
  const std::string too_small = TooSmallText(spec, cell.objects());
  CheckInput(too_small.empty(), too_small);
  setup.cache_dir = CacheDir();
  setup.threads = threads;
  setup.on_progress = on_progress;
  setup.bin = cell.bin();
  setup.log_dir = log_dir;
  if (EstimatorNamed(spec.estimator.name).renders) views_ = CellViews(cell, setup.objects);
  setup.views = views_.get();
  estimator_ = WithSettingsKey(spec, "estimator", [&] { return MakeEstimator(setup); });
}

EstimatorRunner::~EstimatorRunner() = default;

void EstimatorRunner::UseObjectsOfCell(std::vector<PoseHypothesis>& hypotheses) const {
  for (PoseHypothesis& hypothesis : hypotheses) {
    hypothesis.object = cell_.wanted()[hypothesis.object];
  }
}

EstimateResult EstimatorRunner::Estimate(const RgbdFrame& frame, Rng& rng, EstimateTrace* trace) {
  return Estimate(frame, {cell_.camera(), std::nullopt}, rng, trace);
}

EstimateResult EstimatorRunner::Estimate(const RgbdFrame& frame, const CellCalibration& calibration,
                                         Rng& rng, EstimateTrace* trace,
                                         const ReachCounter& count_reachable, bool is_first) {
  EstimateResult result;
  StageSeconds seconds;
  EstimatorInput input{frame, calibration.Background(cell_.bin()), trace};
  input.X_WC = calibration.camera.X_WC();
  input.is_first = is_first;
  std::optional<ImageRegion> region;
  if (!roi_.empty()) {
    region = MakeRegion(roi_, frame, calibration.camera.X_CW(), cell_.objects());
    // Later images may lose all readings, because the objects in the region are picked.
    if (is_first) RequireReadingsIn(*region, frame, "roi");
    input.region = &region->pixels;
  }
  if (count_reachable) {
    input.count_reachable = [&](std::span<const PoseHypothesis> poses, int wanted) {
      std::vector<PoseHypothesis> of_cell(poses.begin(), poses.end());
      UseObjectsOfCell(of_cell);
      return count_reachable(of_cell, wanted);
    };
  }
  {
    const StageTimer timer(seconds, "estimate");
    result = estimator_->Estimate(input, rng);
    DropNotFinite(result.hypotheses);
    UseObjectsOfCell(result.hypotheses);
    RemoveOutsideBin(cell_, calibration, result.hypotheses);
    if (region) KeepPosesIn(*region, frame.intrinsics, cell_.objects(), result.hypotheses);
    if (trace) {
      Renumber(cell_.wanted(), *trace);
      RemoveOutsideBin(cell_, calibration, trace->accepted);
      if (region) KeepPosesIn(*region, frame.intrinsics, cell_.objects(), trace->accepted);
    }
  }
  for (const auto& [stage, value] : result.seconds)
    seconds[std::string(kEstimatorStage) + stage] += value;
  seconds.merge(TakeNotFiniteCounts());
  result.seconds = std::move(seconds);
  return result;
}

std::unique_ptr<EstimatorRunner> MakeEstimatorRunner(const SimulatedCell& cell,
                                                     const ScenarioSpec& spec, int threads,
                                                     const EstimatorRunner::Progress& on_progress,
                                                     const std::filesystem::path& log_dir) {
  RequireNames(spec);
  if (spec.estimator.name == kOracleName) return nullptr;
  return std::make_unique<EstimatorRunner>(cell, spec, threads, on_progress, log_dir);
}

}  // namespace pickbed::eval
