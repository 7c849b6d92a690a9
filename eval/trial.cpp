#include "eval/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "eval/blame.h"
#include "eval/estimator_runner.h"
#include "eval/matching.h"
#include "eval/oracle.h"
#include "eval/trial_impl.h"
#include "eval/trial_observer.h"
#include "grasp/require_candidates.h"

namespace pickbed {
namespace {

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

// The instance that a hypothesis stands on, -1 = none.
int AimOf(const HypothesisScore& believed, double stands_on_diameters) {
  return believed.mssd_diameters < stands_on_diameters ? believed.instance : -1;
}

}  // namespace

TrialRunner::Impl::Impl(const ScenarioSpec& scenario, const ObjectSet& objects,
                        const Progress& progress, const TrialOptions& trial_options)
    : spec(scenario),
      on_progress(progress),
      options(trial_options),
      cell(scenario, objects),
      gripper(BlameKey(scenario, "gripper", [&] { return LoadGripper(scenario.gripper); })) {
  BlameKey(scenario, "policy.stop", [&] { PolicyNamed(scenario.policy.stop); });
  BlameKey(scenario, "policy.ranking", [&] { RankingNamed(scenario.policy.ranking); });
  execute.rule =
      BlameKey(scenario, "policy.success", [&] { return DecidingRule(scenario.policy.success); });
  const TruthStages& truth = options.truth;
  if (!truth.AllOfPerception()) {
    estimator = std::make_unique<EstimatorRunner>(cell, scenario, 1, progress);
  }
  if (truth.pose && !truth.refinement && scenario.estimator.name != kOracleName) {
    fed_refiner = std::make_unique<FedRefiner>(cell.objects(), scenario.refiner);
  }
  for (size_t i = 0; i < cell.objects().size(); ++i) {
    const ObjectModel& model = *cell.objects()[i];
    metric_models.push_back(MakeMetricModel(model));
    candidates.emplace_back();  // none of a part that is not to be picked
    if (!cell.IsWanted(static_cast<int>(i))) continue;
    BlameKey(scenario, "gripper", [&] { candidates.back() = RequireCandidates(model, gripper); });
  }
}

TrialRunner::Impl::Live TrialRunner::Impl::Drop(int scene) {
  Live live;
  live.result.trial = live.result.scene = scene;
  StageTimer timer(live.result.seconds, "drop");
  CertifiedScene made = cell.MakeScene(scene);
  live.result.certificate = std::move(made.certificate);
  live.result.refused = std::move(made.refused);
  live.result.parts_dropped = cell.WantedIn(made.scene);
  for (const PosedObject& posed : made.scene.objects) {
    if (!cell.IsWanted(posed.object)) continue;
    InstanceFate& fate = live.result.fates.emplace_back();
    fate.instance = posed.instance;
    fate.object = posed.object;
  }
  live.scene = std::move(made.scene);
  return live;
}

View TrialRunner::Impl::See(Live& live, int look) {
  StageTimer timer(live.result.seconds, "see");
  return cell.See(live.scene, live.result.scene, look);
}

std::vector<PoseHypothesis> TrialRunner::Impl::Fed(std::vector<PoseHypothesis> believed,
                                                   const View& view, const Scene& scene) const {
  const TruthStages& truth = options.truth;
  if (!truth.detection && !truth.pose && !truth.refinement) return believed;
  const Pose X_CW = cell.camera().X_WC.inverse();
  std::vector<FedPart> parts;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const double visible = view.visible_fractions[i];
    if (!cell.IsWanted(posed.object)) continue;
    if (!truth.sense && visible < kCountedVisibility) continue;
    parts.push_back({posed.object, X_CW * posed.X_WO, visible});
  }
  believed = WithTruth(std::move(believed), parts, metric_models, truth);
  if (fed_refiner) fed_refiner->Refine(view.frame, {cell.bin(), X_CW}, believed);
  return believed;
}

std::vector<PoseHypothesis> TrialRunner::Impl::Believe(const View& view, Live& live,
                                                       PickRecord& record) {
  if (!estimator) return Fed({}, view, live.scene);
  Rng rng = Rng::Derive(spec.seed, live.result.scene, fmt::format("estimate/{}", record.pick));
  EstimateResult result = estimator->Estimate(live.scene, view, rng);
  for (const auto& [stage, value] : result.seconds) live.result.seconds[stage] += value;
  return Fed(std::move(result.hypotheses), view, live.scene);
}

std::vector<PoseHypothesis> TrialRunner::Impl::Estimate(const View& view, Live& live,
                                                        PickRecord& record) {
  std::vector<PoseHypothesis> hypotheses = Believe(view, live, record);
  StageTimer timer(live.result.seconds, "score");
  LookScore score =
      ScoreLook(live.scene, view.visible_fractions, metric_models, cell.camera(), hypotheses);
  const std::vector<Loss> missed =
      WhyMissed(score, hypotheses, {live.scene, metric_models, cell.camera()});
  for (size_t i = 0; i < missed.size(); ++i) score.instances[i].missed = missed[i];
  record.instances = std::move(score.instances);
  record.hypotheses = std::move(score.hypotheses);
  return hypotheses;
}

std::vector<int> TrialRunner::Impl::AimsOf(const PickRecord& record) const {
  std::vector<int> aims;
  for (size_t i = 0; i < record.hypotheses.size(); ++i) {
    const int aim = AimOf(record.hypotheses[i], options.stands_on_diameters);
    if (record.target < 0 || aim == record.target) aims.push_back(static_cast<int>(i));
  }
  return aims;
}

std::vector<Grasp> TrialRunner::Impl::Plan(const View& view, const std::vector<BelievedPose>& poses,
                                           Live& live, PickRecord& record) {
  StageTimer timer(live.result.seconds, "plan");
  const auto cloud_W = ObservedPoints(view.frame, cell.camera().X_WC, options.cloud_stride_px);
  PlanOptions plan_options = Ranking(live, record);
  if (options.truth.grasp) plan_options.max_grasps = options.true_grasps;
  if (!live.failed.empty()) plan_options.max_grasps = options.retry_grasps;
  const std::vector<int> aims = AimsOf(record);
  PlanResult plan = PlanGrasps(
      {cell.bin(), poses, candidates, cloud_W, cell.objects(), gripper, aims}, plan_options);
  record.grasps_rejected = std::move(plan.rejected);
  const size_t planned = plan.grasps.size();
  auto grasps = WithoutRetries(std::move(plan.grasps), poses, live.failed);
  if (grasps.size() < planned) {
    record.grasps_rejected["failed before"] = static_cast<int>(planned - grasps.size());
  }
  return grasps;
}

PlanOptions TrialRunner::Impl::Ranking(const Live& live, const PickRecord& record) const {
  PlanOptions plan_options;
  plan_options.ranking = spec.policy.ranking;
  plan_options.seed =
      Rng::Derive(spec.seed, live.result.scene, fmt::format("plan/{}", record.pick)).Next();
  return plan_options;
}

std::vector<Grasp> TrialRunner::Impl::PlanBoldly(const std::vector<BelievedPose>& poses,
                                                 const Live& live, const PickRecord& record) const {
  PlanOptions bold = Ranking(live, record);
  bold.max_grasps = options.true_grasps;
  bold.max_tilt_rad = 0.5 * std::numbers::pi;
  bold.min_quality = 0;
  bold.bin_clearance_m = 0;
  bold.neighbor_confidence = std::numeric_limits<double>::infinity();
  const std::vector<int> aims = AimsOf(record);
  PlanResult plan =
      PlanGrasps({cell.bin(), poses, candidates, {}, cell.objects(), gripper, aims}, bold);
  return WithoutRetries(std::move(plan.grasps), poses, live.failed);
}

std::vector<Grasp> TrialRunner::Impl::WithoutRetries(std::vector<Grasp> grasps,
                                                     const std::vector<BelievedPose>& poses,
                                                     const std::vector<FailedGrasp>& failed) const {
  std::vector<FailedGrasp> in_this_bin = failed;
  std::erase_if(in_this_bin, [](const FailedGrasp& old) { return old.picked_since; });
  const auto without = [&](const std::vector<FailedGrasp>& known) {
    std::vector<Grasp> fresh;
    for (const Grasp& grasp : grasps) {
      if (!IsRetry(grasp, poses[grasp.hypothesis], known, options)) fresh.push_back(grasp);
    }
    return fresh;
  };
  std::vector<Grasp> fresh = without(failed);
  return fresh.empty() ? without(in_this_bin) : fresh;
}

std::optional<Grasp> TrialRunner::Impl::FirstThatSucceeds(const std::vector<Grasp>& grasps,
                                                          const std::vector<BelievedPose>& poses,
                                                          const Live& live,
                                                          const PickRecord& record) const {
  const size_t tried = std::min<size_t>(grasps.size(), options.true_grasps);
  for (size_t i = 0; i < tried; ++i) {
    const BelievedPose& pose = poses[grasps[i].hypothesis];
    if (Try(live.scene, grasps[i], pose, record).outcome.success) return grasps[i];
  }
  return std::nullopt;
}

std::optional<Grasp> TrialRunner::Impl::Choose(const std::vector<BelievedPose>& poses,
                                               const std::vector<Grasp>& planned, Live& live,
                                               const PickRecord& record) const {
  if (options.truth.grasp) {
    StageTimer timer(live.result.seconds, "try");
    if (const auto grasp = FirstThatSucceeds(planned, poses, live, record)) return grasp;
    const std::vector<Grasp> bold = PlanBoldly(poses, live, record);
    if (const auto grasp = FirstThatSucceeds(bold, poses, live, record)) return grasp;
  }
  return planned.empty() ? std::nullopt : std::optional(planned.front());
}

ExecuteResult TrialRunner::Impl::Try(const Scene& scene, const Grasp& grasp,
                                     const BelievedPose& pose, const PickRecord& record) const {
  const int aim = AimOf(record.hypotheses[grasp.hypothesis], options.stands_on_diameters);
  return ExecuteGrasp(scene, cell.objects(), grasp, gripper, {aim, pose.object, pose.X_WO},
                      execute);
}

void TrialRunner::Impl::Execute(const PoseHypothesis& hypothesis, const BelievedPose& pose,
                                Live& live, PickRecord& record) {
  StageTimer timer(live.result.seconds, "execute");
  record.aimed = AimOf(record.hypotheses[record.chosen], options.stands_on_diameters);
  ExecuteResult executed = Try(live.scene, *record.grasp, pose, record);
  record.outcome = executed.outcome;
  record.loss = LossOf(record, hypothesis, {live.scene, metric_models, cell.camera()});
  live.scene = std::move(executed.after);
  if (record.outcome.success) {
    for (FailedGrasp& old : live.failed) old.picked_since = true;
  } else {
    live.failed.push_back(
        {pose.object, pose.X_WO.translation(), record.grasp->X_WG.linear().col(2)});
  }
}

void TrialRunner::Impl::PickOnce(Live& live, int target, int band) {
  PickRecord& record = live.result.picks.emplace_back();
  record.pick = static_cast<int>(live.result.picks.size()) - 1;
  record.target = target;
  record.band = band;
  LookState look{live.result.scene, cell, gripper, live.scene, record};
  const auto reach = [&](TrialStage stage) { ReachStage(stage, look, record, live.observer); };

  reach(TrialStage::kScene);
  const View view = See(live, record.pick);
  look.view = &view;
  reach(TrialStage::kImage);
  const auto hypotheses = Estimate(view, live, record);
  look.hypotheses = &hypotheses;
  reach(TrialStage::kHypotheses);
  std::vector<BelievedPose> poses;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    poses.push_back({hypothesis.object, cell.camera().X_WC * hypothesis.X_CO, hypothesis.score});
  }
  const std::vector<int> aims = AimsOf(record);
  if (!aims.empty()) record.grasp = Choose(poses, Plan(view, poses, live, record), live, record);
  reach(TrialStage::kGrasp);
  if (record.grasp) {
    record.chosen = record.grasp->hypothesis;
    Execute(hypotheses[record.chosen], poses[record.chosen], live, record);
  } else {
    const LookTruth truth{live.scene, metric_models, cell.camera()};
    record.loss = target < 0 ? LossWithoutGrasp(record, hypotheses, truth)
                             : LossWithoutGraspOnTarget(record, aims, hypotheses, truth);
  }
  reach(TrialStage::kOutcome);
}

void TrialRunner::Impl::PickAll(Live& live) {
  const PolicySpec& policy = spec.policy;
  const PolicyRow& row = PolicyNamed(policy.stop);
  const int most_looks = row.most_looks > 0 ? row.most_looks : policy.max_picks;
  TrialResult& result = live.result;
  PolicyState state;
  while (cell.WantedIn(live.scene) > 0 && (most_looks == 0 || state.looks < most_looks)) {
    PickOnce(live);
    const PickRecord& pick = result.picks.back();
    const bool picked = pick.loss == Loss::kNone;
    result.parts_cleared += picked;
    if (on_progress) {
      const double cleared = static_cast<double>(result.parts_cleared) / result.parts_dropped;
      on_progress(fmt::format("trial {}", result.trial), cleared);
    }
    ++state.looks;
    state.grasp_found = pick.grasp.has_value();
    state.failures_in_row = picked ? 0 : state.failures_in_row + 1;
    if (!row.gives_up(state, policy)) continue;
    result.ended_by = pick.loss;
    return;
  }
}

TrialRunner::TrialRunner(const ScenarioSpec& spec, const ObjectSet& objects,
                         const Progress& on_progress, const TrialOptions& options)
    : impl_(std::make_unique<Impl>(spec, objects, on_progress, options)) {}

TrialRunner::~TrialRunner() = default;

TrialResult TrialRunner::Run(int scene, TrialObserver* observer) {
  if (impl_->spec.occlusion.enabled) return impl_->RunSeries(scene, observer);
  Impl::Live live = impl_->Drop(scene);
  live.observer = observer;
  impl_->PickAll(live);
  TrialResult& result = live.result;
  TrialEnd end;
  end.gave_up = result.ended_by != Loss::kNone;
  for (const PosedObject& posed : live.scene.objects) end.remaining.push_back(posed.instance);
  result.fates = FatesOf(std::move(result.fates), result.picks, end);
  return std::move(result);
}

}  // namespace pickbed
