#include "eval/trial.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/blame.h"
#include "eval/estimator_runner.h"
#include "eval/matching.h"
#include "eval/pictures.h"
#include "eval/virtual_cell.h"
#include "grasp/antipodal.h"

namespace pickbed {
namespace {

// A grasp that failed, in the world.
struct FailedGrasp {
  int object = 0;
  Eigen::Vector3d position_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d approach_W = Eigen::Vector3d::UnitZ();
};

bool IsRetry(const Grasp& grasp, const BelievedPose& pose, const std::vector<FailedGrasp>& failed,
             const TrialOptions& options) {
  return std::any_of(failed.begin(), failed.end(), [&](const FailedGrasp& old) {
    const double cosine = old.approach_W.dot(grasp.X_WG.linear().col(2));
    return old.object == pose.object &&
           (old.position_W - pose.X_WO.translation()).norm() < options.retry_radius_m &&
           std::acos(std::clamp(cosine, -1.0, 1.0)) < options.retry_angle_rad;
  });
}

std::vector<Eigen::Vector3d> ObservedPoints(const RgbdFrame& frame, const Pose& X_WC, int stride) {
  std::vector<Eigen::Vector3d> points_W;
  for (int v = 0; v < frame.depth_m.height(); v += stride) {
    for (int u = 0; u < frame.depth_m.width(); u += stride) {
      const float depth_m = frame.depth_m(u, v);
      if (depth_m <= 0) continue;
      points_W.push_back(X_WC * BackProject(frame.intrinsics, u, v, depth_m));
    }
  }
  return points_W;
}

// Why a look gave no hypothesis at all.
Loss WhyNothing(const std::vector<InstanceRecord>& instances) {
  const bool any_visible =
      std::any_of(instances.begin(), instances.end(), [](const InstanceRecord& instance) {
        return instance.visible_fraction >= kCountedVisibility;
      });
  return any_visible ? Loss::kNoProposal : Loss::kNotVisible;
}

}  // namespace

struct TrialRunner::Impl {
  // A trial under way.
  struct Live {
    std::filesystem::path picture_folder;  // empty = none
    TrialResult result;
    Scene scene;
    std::vector<FailedGrasp> failed;  // since the last success
  };

  Impl(const ScenarioSpec& spec, const ObjectSet& objects, const Progress& on_progress,
       const TrialOptions& options);

  Live Drop(int trial, const std::filesystem::path& picture_folder);
  View See(Live& live, int look);
  // One look: fills the record's instances and hypotheses.
  std::vector<PoseHypothesis> Estimate(const View& view, Live& live, PickRecord& record);
  std::optional<Grasp> Plan(const View& view, const std::vector<BelievedPose>& poses, Live& live,
                            PickRecord& record);
  void Execute(const PoseHypothesis& hypothesis, const BelievedPose& pose, Live& live,
               PickRecord& record);
  void PickOnce(Live& live);

  ScenarioSpec spec;
  Progress on_progress;
  TrialOptions options;
  VirtualCell cell;
  GripperSpec gripper;
  std::vector<MetricModel> metric_models;
  std::vector<std::vector<GraspCandidate>> candidates;
  EstimatorRunner estimator;
};

TrialRunner::Impl::Impl(const ScenarioSpec& scenario, const ObjectSet& objects,
                        const Progress& progress, const TrialOptions& trial_options)
    : spec(scenario),
      on_progress(progress),
      options(trial_options),
      cell(scenario, objects),
      gripper(BlameKey(scenario, "gripper", [&] { return LoadGripper(scenario.gripper); })),
      estimator(cell, scenario, 1, progress) {
  for (const auto& model : cell.objects()) {
    metric_models.push_back(MakeMetricModel(*model));
    candidates.push_back(CachedAntipodalGrasps(*model, gripper));
  }
}

TrialRunner::Impl::Live TrialRunner::Impl::Drop(int trial,
                                                const std::filesystem::path& picture_folder) {
  Live live;
  live.picture_folder = picture_folder;
  live.result.trial = trial;
  StageTimer timer(live.result.seconds, "drop");
  CertifiedScene made = cell.MakeScene(trial);
  live.result.certificate = std::move(made.certificate);
  live.result.refused = std::move(made.refused);
  live.result.parts_dropped = cell.WantedIn(made.scene);
  live.scene = std::move(made.scene);
  return live;
}

View TrialRunner::Impl::See(Live& live, int look) {
  StageTimer timer(live.result.seconds, "see");
  return cell.See(live.scene, live.result.trial, look);
}

std::vector<PoseHypothesis> TrialRunner::Impl::Estimate(const View& view, Live& live,
                                                        PickRecord& record) {
  StageSeconds& seconds = live.result.seconds;
  Rng rng = Rng::Derive(spec.seed, live.result.trial, fmt::format("estimate/{}", record.pick));
  EstimateResult result = estimator.Estimate(live.scene, view, rng);
  for (const auto& [stage, value] : result.seconds) seconds[stage] += value;
  StageTimer timer(seconds, "score");
  LookScore score = ScoreLook(live.scene, view.visible_fractions, metric_models, cell.camera(),
                              result.hypotheses);
  record.instances = std::move(score.instances);
  record.hypotheses = std::move(score.hypotheses);
  return std::move(result.hypotheses);
}

std::optional<Grasp> TrialRunner::Impl::Plan(const View& view,
                                             const std::vector<BelievedPose>& poses, Live& live,
                                             PickRecord& record) {
  StageTimer timer(live.result.seconds, "plan");
  const auto cloud_W = ObservedPoints(view.frame, cell.camera().X_WC, options.cloud_stride_px);
  PlanOptions plan_options;
  if (!live.failed.empty()) plan_options.max_grasps = options.retry_grasps;
  PlanResult plan =
      PlanGrasps({cell.bin(), poses, candidates, cloud_W, cell.objects(), gripper}, plan_options);
  record.grasps_rejected = std::move(plan.rejected);
  for (const Grasp& grasp : plan.grasps) {
    if (!IsRetry(grasp, poses[grasp.hypothesis], live.failed, options)) return grasp;
  }
  return std::nullopt;
}

void TrialRunner::Impl::Execute(const PoseHypothesis& hypothesis, const BelievedPose& pose,
                                Live& live, PickRecord& record) {
  StageTimer timer(live.result.seconds, "execute");
  const HypothesisScore& chosen = record.hypotheses[record.chosen];
  const bool stands_on_one = chosen.mssd_diameters < options.stands_on_diameters;
  ExecuteResult executed =
      ExecuteGrasp(live.scene, cell.objects(), *record.grasp, gripper,
                   {stands_on_one ? chosen.instance : -1, pose.object, pose.X_WO});
  record.outcome = executed.outcome;
  record.loss = LossOf(record, hypothesis, {live.scene, metric_models, cell.camera()});
  live.scene = std::move(executed.after);
  if (record.outcome.success) {
    live.failed.clear();
  } else {
    live.failed.push_back(
        {pose.object, pose.X_WO.translation(), record.grasp->X_WG.linear().col(2)});
  }
}

void TrialRunner::Impl::PickOnce(Live& live) {
  PickRecord& record = live.result.picks.emplace_back();
  record.pick = static_cast<int>(live.result.picks.size()) - 1;
  const PickPictures pictures(live.picture_folder, record.pick);

  const View view = See(live, record.pick);
  const auto hypotheses = Estimate(view, live, record);
  std::vector<BelievedPose> poses;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    poses.push_back({hypothesis.object, cell.camera().X_WC * hypothesis.X_CO, hypothesis.score});
  }
  if (!poses.empty()) record.grasp = Plan(view, poses, live, record);
  pictures.Write({view.frame, cell.camera(), cell.objects(), live.scene, hypotheses,
                  record.grasp ? &*record.grasp : nullptr, &gripper, &view.ids});
  if (record.grasp) {
    record.chosen = record.grasp->hypothesis;
    Execute(hypotheses[record.chosen], poses[record.chosen], live, record);
  } else {
    record.loss = poses.empty() ? WhyNothing(record.instances) : Loss::kNoGrasp;
  }
  if (pictures.wanted()) pictures.WriteAfter(cell.ColorPicture(live.scene, live.result.trial));
}

TrialRunner::TrialRunner(const ScenarioSpec& spec, const ObjectSet& objects,
                         const Progress& on_progress, const TrialOptions& options)
    : impl_(std::make_unique<Impl>(spec, objects, on_progress, options)) {}

TrialRunner::~TrialRunner() = default;

TrialResult TrialRunner::Run(int trial, const std::filesystem::path& picture_folder) {
  const PolicySpec& policy = impl_->spec.policy;
  const size_t max_picks = policy.stop == "one_pick" ? 1 : policy.max_picks;
  Impl::Live live = impl_->Drop(trial, picture_folder);
  TrialResult& result = live.result;
  int failures_in_row = 0;
  while (result.ended_by == Loss::kNone && impl_->cell.WantedIn(live.scene) > 0) {
    if (max_picks > 0 && result.picks.size() == max_picks) break;
    impl_->PickOnce(live);
    const PickRecord& pick = result.picks.back();
    const bool picked = pick.loss == Loss::kNone;
    result.parts_cleared += picked;
    if (impl_->on_progress) {
      const double cleared = static_cast<double>(result.parts_cleared) / result.parts_dropped;
      impl_->on_progress(fmt::format("trial {}", trial), cleared);
    }
    failures_in_row = picked ? 0 : failures_in_row + 1;
    if (!pick.grasp || failures_in_row >= policy.max_failures_in_row) result.ended_by = pick.loss;
  }
  return std::move(result);
}

}  // namespace pickbed
