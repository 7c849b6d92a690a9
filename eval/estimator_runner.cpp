#include "eval/estimator_runner.h"

#include "eval/oracle.h"
#include "scenes/files.h"
#include "sim/view_source.h"

namespace pickbed {
namespace {

double WorkingDistance(const Camera& camera, const Bin& bin) {
  const Eigen::Vector3d middle_W(0, 0, bin.inner_size_m.z() / 4);
  return (camera.X_WC.inverse() * middle_W).z();
}

std::unique_ptr<LabelledViewSource> ViewsOf(const VirtualCell& cell, const ObjectSet& objects) {
  ViewSourceOptions options;
  options.sensor = cell.sensor();
  options.camera = cell.camera().intrinsics;
  options.bin = cell.bin();
  return MakeSimViewSource(objects, options);
}

}  // namespace

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
  setup.working_distance_m = WorkingDistance(cell.camera(), cell.bin());
  views_ = ViewsOf(cell, setup.objects);
  setup.views = views_.get();
  setup.cache_dir = CacheDir();
  setup.threads = threads;
  setup.on_progress = on_progress;
  for (const EstimatorRow& row : EstimatorTable()) {
    if (spec_.name != row.name) continue;
    estimator_ = BlameKey(spec, "estimator", [&] { return row.make(setup); });
  }
}

EstimatorRunner::~EstimatorRunner() = default;

EstimateResult EstimatorRunner::Estimate(const Scene& truth, const View& view, Rng& rng) {
  EstimateResult result;
  StageSeconds seconds;
  {
    const StageTimer timer(seconds, "estimate");
    if (estimator_) {
      const KnownBackground background{cell_.bin(), cell_.camera().X_WC.inverse()};
      result = estimator_->Estimate({view.frame, background}, rng);
      for (PoseHypothesis& hypothesis : result.hypotheses) {
        hypothesis.object = cell_.wanted()[hypothesis.object];
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
