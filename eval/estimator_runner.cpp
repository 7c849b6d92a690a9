#include "eval/estimator_runner.h"

#include "eval/oracle.h"
#include "perception/estimate_trace.h"
#include "scenes/files.h"
#include "sim/view_source.h"

namespace pickbed {
namespace {

// From the estimator's own numbers of the parts to those of the cell.
void Renumber(const std::vector<int>& wanted, EstimateTrace& trace) {
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

std::unique_ptr<LabelledViewSource> CellViews(const VirtualCell& cell, const ObjectSet& objects) {
  ViewSourceOptions options;
  options.sensor = cell.sensor();
  options.camera = cell.camera().intrinsics;
  options.bin = cell.bin();
  return MakeSimViewSource(objects, options);
}

void KeepThoseInBin(const VirtualCell& cell, std::vector<PoseHypothesis>& hypotheses) {
  const Pose& X_WC = cell.camera().X_WC;
  std::erase_if(hypotheses, [&](const PoseHypothesis& hypothesis) {
    const Eigen::Vector3d& com_O = cell.objects()[hypothesis.object]->mass.com_O;
    return !cell.bin().Holds(X_WC * hypothesis.X_CO * com_O);
  });
}

EstimatorRunner::EstimatorRunner(const VirtualCell& cell, const ScenarioSpec& spec, int threads,
                                 const Progress& on_progress)
    : cell_(cell), spec_(spec.estimator) {
  BlameKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  if (spec_.name == kOracleName) return;
  EstimatorSetup setup;
  for (const int object : cell.wanted()) setup.objects.push_back(cell.objects()[object]);
  setup.spec = spec_;
  setup.refiner = spec.refiner;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = working_distance_m();
  setup.cache_dir = CacheDir();
  setup.threads = threads;
  setup.on_progress = on_progress;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (spec_.name != row.name) continue;
    if (row.renders) views_ = CellViews(cell, setup.objects);
    setup.views = views_.get();
    estimator_ = BlameKey(spec, "estimator", [&] { return row.make(setup); });
  }
}

EstimatorRunner::~EstimatorRunner() = default;

double EstimatorRunner::working_distance_m() const {
  const Eigen::Vector3d middle_W(0, 0, cell_.bin().inner_size_m.z() / 4);
  return (cell_.camera().X_WC.inverse() * middle_W).z();
}

EstimateResult EstimatorRunner::Estimate(const Scene& truth, const View& view, Rng& rng,
                                         EstimateTrace* trace) {
  EstimateResult result;
  StageSeconds seconds;
  {
    const StageTimer timer(seconds, "estimate");
    if (estimator_) {
      const KnownBackground background{cell_.bin(), cell_.camera().X_WC.inverse()};
      result = estimator_->Estimate({view.frame, background, trace}, rng);
      for (PoseHypothesis& hypothesis : result.hypotheses) {
        hypothesis.object = cell_.wanted()[hypothesis.object];
      }
      KeepThoseInBin(cell_, result.hypotheses);
      if (trace) {
        Renumber(cell_.wanted(), *trace);
        KeepThoseInBin(cell_, trace->accepted);
      }
    } else {
      result.hypotheses = OracleEstimate(truth, view, cell_.camera(), spec_, rng);
    }
  }
  for (const auto& [stage, value] : result.seconds) seconds["estimate/" + stage] += value;
  result.seconds = std::move(seconds);
  return result;
}

}  // namespace pickbed
