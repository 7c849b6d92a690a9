#include "eval/python/cell.h"

#include <fmt/format.h>

#include "eval/trial/attempt.h"
#include "eval/trial/trial.h"
#include "grasp/grippers/requirements.h"
#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/random.h"

namespace pickbed::eval {

std::vector<std::string> NamesOf(const ObjectSet& objects) {
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  return names;
}

TrialOptions OptionsWith(const CallHooks& hooks) {
  TrialOptions options;
  options.estimator_on_demand = true;
  options.on_warning = hooks.on_warning;
  return options;
}

Cell::Cell(std::shared_ptr<const LoadedScenario> scenario, CallHooks hooks)
    : scenario_(std::move(scenario)),
      hooks_(std::move(hooks)),
      cell_(scenario_->spec, scenario_->objects) {
  cell_.SetOnWait(hooks_.on_wait);
}

TrialSetup& Cell::Setup() {
  if (!setup_) {
    setup_ = std::make_unique<TrialSetup>(
        scenario_->spec, cell_.objects(), [this](std::string_view, double) { hooks_.on_wait(); },
        OptionsWith(hooks_));
    setup_->cell.SetOnWait(hooks_.on_wait);
  }
  return *setup_;
}

void Cell::RequireKnown(const std::vector<PoseHypothesis>& hypotheses) const {
  const int objects = static_cast<int>(cell_.objects().size());
  for (const PoseHypothesis& hypothesis : hypotheses) {
    CheckInput(
        hypothesis.object >= 0 && hypothesis.object < objects,
        fmt::format("a hypothesis is for object {}, but the scenario has the objects 0 to {}",
                    hypothesis.object, objects - 1));
  }
}

void Cell::RequireOwn(const BinContent& content) const {
  CheckInput(content.object_names == NamesOf(cell_.objects()),
             "the bin is of a scenario with other objects; drop it with this cell");
}

BinContent Cell::ContentOf(Scene scene, BinIndex bin_index) const {
  return {std::move(scene), bin_index, NamesOf(cell_.objects())};
}

BinContent Cell::Drop(BinIndex bin_index) {
  return ContentOf(cell_.MakeScene(bin_index).scene, bin_index);
}

CapturedView Cell::Capture(const BinContent& content, int attempt) {
  RequireOwn(content);
  auto observation =
      std::make_shared<Observation>(cell_.Capture(content.scene, content.bin_index, attempt));
  std::vector<TrueInstance> instances =
      InstancesOf(content.scene, observation->visible_fractions, cell_.camera().X_CW());
  return {std::move(observation), content, attempt, std::move(instances)};
}

EstimateResult Cell::Estimate(const CapturedView& view) {
  RequireOwn(view.content);
  TrialSetup& setup = Setup();
  CheckInput(setup.has_poses,
             fmt::format("planner {} works without poses, so there is no estimator",
                         setup.spec.planner.name));
  const InstanceMatcher truth(setup.metric_models, view.instances);
  return EstimateInImage(setup, *view.observation, truth, view.content.bin_index, view.attempt);
}

EstimateResult Cell::EstimateFrame(const RgbdFrame& frame, const Camera& camera, uint64_t seed) {
  TrialSetup& setup = Setup();
  setup.MakeEstimator();
  CheckInput(setup.estimator != nullptr,
             "the scenario has no estimator that works on an image without ground truth; set "
             "estimator.name, see estimator_names()");
  Rng rng(seed);
  return setup.estimator->Estimate(frame, {camera, std::nullopt}, rng);
}

std::vector<HypothesisRecord> Cell::Score(const CapturedView& view,
                                          const std::vector<PoseHypothesis>& hypotheses) {
  RequireOwn(view.content);
  RequireKnown(hypotheses);
  const InstanceMatcher truth(Setup().metric_models, view.instances);
  return ScoreAgainstTruth(truth, cell_.camera(), view.observation->calibration.camera.X_WC(),
                           hypotheses)
      .Records();
}

PlanResult Cell::Plan(const CapturedView& view, const std::vector<PoseHypothesis>& hypotheses,
                      int max_grasps) {
  RequireOwn(view.content);
  RequireKnown(hypotheses);
  CheckInput(max_grasps >= 1, fmt::format("max_grasps = {}: must be at least 1", max_grasps));
  const TrialSetup& setup = Setup();
  const Pose& X_WC = view.observation->calibration.camera.X_WC();
  std::vector<EstimatedPose> poses;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    if (!setup.has_poses) break;
    poses.push_back({hypothesis.object, X_WC * hypothesis.X_CO, hypothesis.score});
  }
  if (setup.has_poses && poses.empty()) return {};
  return PlanInImage(setup, *view.observation, poses, max_grasps,
                     PlanSeed(setup, view.content.bin_index, view.attempt));
}

PickResult Cell::Execute(const BinContent& content, const Grasp& grasp,
                         const std::vector<PoseHypothesis>& hypotheses, int attempt) {
  RequireOwn(content);
  RequireKnown(hypotheses);
  const int count = static_cast<int>(hypotheses.size());
  CheckInput(grasp.hypothesis >= kNoHypothesis && grasp.hypothesis < count,
             fmt::format("the grasp is for hypothesis {}, but there are {} hypotheses",
                         grasp.hypothesis, count));
  const TrialSetup& setup = Setup();
  RequireOpensFor(ToolNamed(setup.tools, grasp.tool), grasp.width_m);
  const std::vector<double> visible(content.scene.objects.size(), 1);  // the target needs no image
  const InstanceMatcher truth(setup.metric_models,
                              InstancesOf(content.scene, visible, cell_.camera().X_CW()));
  const Pose X_WC = CalibrationOf(cell_.camera(), cell_.ErrorsOf(content.bin_index)).camera.X_WC();
  const auto records = ScoreAgainstTruth(truth, cell_.camera(), X_WC, hypotheses).Records();
  const ObjectSet objects = cell_.TrueObjects(content.bin_index);
  ExecuteResult executed = TryGrasp(setup, {content.scene, objects}, grasp, records,
                                    cell_.ErrorsOf(content.bin_index, attempt),
                                    [this](const MotionState&) { hooks_.on_wait(); });
  return {executed.outcome, ContentOf(std::move(executed.after), content.bin_index)};
}

TrialResult Cell::RunTrial(BinIndex bin_index) {
  WaitObserver observer(hooks_);
  TrialSetup& setup = Setup();
  return setup.spec.occlusion.enabled ? RunOcclusionTrial(setup, bin_index, &observer)
                                      : eval::RunTrial(setup, bin_index, &observer);
}

}  // namespace pickbed::eval
