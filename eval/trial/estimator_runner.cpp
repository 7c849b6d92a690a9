#include "eval/trial/estimator_runner.h"

#include <stdexcept>

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

}  // namespace

std::unique_ptr<LabelledViewSource> CellViews(const SimulatedCell& cell, const ObjectSet& objects) {
  ViewSourceOptions options;
  options.sensor = cell.sensor();
  options.camera = cell.camera().intrinsics;
  options.bin = cell.bin();
  return MakeSimViewSource(objects, options);
}

void KeepThoseInBin(const SimulatedCell& cell, std::vector<PoseHypothesis>& hypotheses) {
  const Pose& X_WC = cell.camera().X_WC();
  std::erase_if(hypotheses, [&](const PoseHypothesis& hypothesis) {
    const Eigen::Vector3d& com_O = cell.objects()[hypothesis.object]->mass.com_O;
    return !cell.bin().Holds(X_WC * hypothesis.X_CO * com_O);
  });
}

EstimatorRunner::EstimatorRunner(const SimulatedCell& cell, const ScenarioSpec& spec, int threads,
                                 const Progress& on_progress)
    : cell_(cell), spec_(spec.estimator) {
  WithSettingsKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  WithSettingsKey(spec, "refiner", [&] { RefinerNamed(spec.refiner); });
  if (spec_.name == kOracleName) return;
  EstimatorSetup setup;
  for (const ObjectId object : cell.wanted()) setup.objects.push_back(cell.objects()[object]);
  setup.spec = spec_;
  setup.refiner = spec.refiner;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = working_distance_m();
  setup.cache_dir = CacheDir();
  setup.threads = threads;
  setup.on_progress = on_progress;
  if (EstimatorNamed(spec_.name).renders) views_ = CellViews(cell, setup.objects);
  setup.views = views_.get();
  estimator_ = WithSettingsKey(spec, "estimator", [&] { return MakeEstimator(setup); });
}

EstimatorRunner::~EstimatorRunner() = default;

double EstimatorRunner::working_distance_m() const {
  const Eigen::Vector3d center_W(0, 0, cell_.bin().inner_size_m.z() / 4);
  return (cell_.camera().X_CW() * center_W).z();
}

EstimateResult EstimatorRunner::Estimate(const RgbdFrame& frame, Rng& rng, EstimateTrace* trace) {
  if (is_oracle()) throw std::logic_error("the oracle does not estimate");
  EstimateResult result;
  StageSeconds seconds;
  {
    const StageTimer timer(seconds, "estimate");
    const KnownBackground background{cell_.bin(), cell_.camera().X_CW()};
    result = estimator_->Estimate({frame, background, trace}, rng);
    for (PoseHypothesis& hypothesis : result.hypotheses) {
      hypothesis.object = cell_.wanted()[hypothesis.object];
    }
    KeepThoseInBin(cell_, result.hypotheses);
    if (trace) {
      Renumber(cell_.wanted(), *trace);
      KeepThoseInBin(cell_, trace->accepted);
    }
  }
  for (const auto& [stage, value] : result.seconds) seconds["estimate/" + stage] += value;
  result.seconds = std::move(seconds);
  return result;
}

}  // namespace pickbed::eval
