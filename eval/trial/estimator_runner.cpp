#include "eval/trial/estimator_runner.h"

#include "eval/trial/oracle_estimator.h"
#include "perception/candidates/estimate_trace.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/files.h"
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

void KeepThoseInBin(const SimulatedCell& cell, const CellCalibration& calibration,
                    std::vector<PoseHypothesis>& hypotheses) {
  const Pose X_BC = calibration.X_BD();
  std::erase_if(hypotheses, [&](const PoseHypothesis& hypothesis) {
    const Eigen::Vector3d& com_O = cell.objects()[hypothesis.object]->mass.com_O;
    return !cell.bin().Holds(X_BC * hypothesis.X_CO * com_O);
  });
}

double WorkingDistance_m(const SimulatedCell& cell) {
  const Eigen::Vector3d center_W(0, 0, cell.bin().inner_size_m.z() / 4);
  return (cell.camera().X_CW() * center_W).z();
}

EstimatorRunner::EstimatorRunner(const SimulatedCell& cell, const ScenarioSpec& spec, int threads,
                                 const Progress& on_progress)
    : cell_(cell) {
  RequireNames(spec);
  EstimatorSetup setup;
  for (const ObjectId object : cell.wanted()) setup.objects.push_back(cell.objects()[object]);
  setup.spec = spec.estimator;
  setup.refiner = spec.refiner;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = WorkingDistance_m(cell);
  setup.cache_dir = CacheDir();
  setup.threads = threads;
  setup.on_progress = on_progress;
  if (EstimatorNamed(spec.estimator.name).renders) views_ = CellViews(cell, setup.objects);
  setup.views = views_.get();
  estimator_ = WithSettingsKey(spec, "estimator", [&] { return MakeEstimator(setup); });
}

EstimatorRunner::~EstimatorRunner() = default;

EstimateResult EstimatorRunner::Estimate(const RgbdFrame& frame, Rng& rng, EstimateTrace* trace) {
  return Estimate(frame, {cell_.camera(), std::nullopt}, rng, trace);
}

EstimateResult EstimatorRunner::Estimate(const RgbdFrame& frame, const CellCalibration& calibration,
                                         Rng& rng, EstimateTrace* trace) {
  EstimateResult result;
  StageSeconds seconds;
  {
    const StageTimer timer(seconds, "estimate");
    result = estimator_->Estimate({frame, calibration.Background(cell_.bin()), trace}, rng);
    for (PoseHypothesis& hypothesis : result.hypotheses) {
      hypothesis.object = cell_.wanted()[hypothesis.object];
    }
    KeepThoseInBin(cell_, calibration, result.hypotheses);
    if (trace) {
      Renumber(cell_.wanted(), *trace);
      KeepThoseInBin(cell_, calibration, trace->accepted);
    }
  }
  for (const auto& [stage, value] : result.seconds) seconds["estimate/" + stage] += value;
  result.seconds = std::move(seconds);
  return result;
}

std::unique_ptr<EstimatorRunner> MakeEstimatorRunner(const SimulatedCell& cell,
                                                     const ScenarioSpec& spec, int threads,
                                                     const EstimatorRunner::Progress& on_progress) {
  RequireNames(spec);
  if (spec.estimator.name == kOracleName) return nullptr;
  return std::make_unique<EstimatorRunner>(cell, spec, threads, on_progress);
}

}  // namespace pickbed::eval
