#include "eval/estimator_runner.h"

#include "eval/oracle.h"
#include "scenes/files.h"
#include "sim/view_source.h"

namespace pickbed {
namespace {

std::unique_ptr<LabelledViewSource> ViewsOf(const VirtualCell& cell) {
  ViewSourceOptions options;
  options.sensor = cell.sensor();
  options.camera = cell.camera().intrinsics;
  options.bin = cell.bin();
  return MakeSimViewSource(cell.objects(), options);
}

}  // namespace

EstimatorRunner::EstimatorRunner(const VirtualCell& cell, const ScenarioSpec& spec,
                                 const Progress& on_progress)
    : cell_(cell), spec_(spec.estimator) {
  BlameKey(spec, "estimator.name", [&] { RequireEstimator(spec.estimator.name); });
  if (spec_.name == kOracleName) return;
  views_ = ViewsOf(cell);
  EstimatorSetup setup;
  setup.objects = cell.objects();
  setup.spec = spec_;
  setup.refiner = spec.refiner;
  setup.intrinsics = cell.camera().intrinsics;
  setup.working_distance_m = working_distance_m();
  setup.views = views_.get();
  setup.cache_dir = CacheDir();
  setup.on_progress = on_progress;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (spec_.name != row.name) continue;
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
    } else {
      result.hypotheses = OracleEstimate(truth, view, cell_.camera(), spec_, rng);
    }
  }
  for (const auto& [stage, value] : result.seconds) seconds["estimate/" + stage] += value;
  result.seconds = std::move(seconds);
  return result;
}

}  // namespace pickbed
