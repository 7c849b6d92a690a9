#include "eval/python/picking_env.h"

#include <fmt/format.h>

#include <limits>

#include "eval/sweep/run.h"
#include "scenes/base/error.h"
#include "scenes/base/ids_format.h"

namespace pickbed::eval {
namespace {

// Checks the scenario as a run does, before anything is loaded.
const LoadedScenario& Checked(const LoadedScenario& scenario) {
  CheckInput(!scenario.spec.occlusion.enabled,
             fmt::format("{}: an occlusion trial is no episode of single picks; set it to false",
                         scenario.spec.At("occlusion.enabled")));
  RunIdentity(scenario.spec, scenario.objects);
  return scenario;
}

}  // namespace

BinPickingEnv::BinPickingEnv(std::shared_ptr<const LoadedScenario> scenario, CallHooks hooks)
    : scenario_(std::move(scenario)),
      hooks_(std::move(hooks)),
      observer_(hooks_),
      setup_(
          Checked(*scenario_).spec, scenario_->objects,
          [this](std::string_view, double) { hooks_.on_wait(); }, OptionsWith(hooks_)) {
  setup_.cell.SetOnWait(hooks_.on_wait);
}

BinPickingEnv::~BinPickingEnv() = default;

void BinPickingEnv::Reset(std::optional<uint64_t> seed, std::optional<int> bin_index) {
  CheckInput(!bin_index || *bin_index >= 0,
             fmt::format("bin_index = {}: must not be negative", bin_index.value_or(0)));
  if (seed) {
    setup_.SetSeed(*seed);
    trials_.clear();
    own_grasps_ = false;
    next_bin_ = 0;
  }
  const int bin = bin_index.value_or(next_bin_);
  trial_ = nullptr;
  final_view_.reset();
  interrupted_ = terminated_ = truncated_ = has_own_grasp_ = false;
  trial_ = std::make_unique<PickingTrial>(setup_, BinIndex(bin), &observer_);
  next_bin_ = bin < std::numeric_limits<int>::max() ? bin + 1 : bin;
  trial_->Attempt();
}

PickingTrial& BinPickingEnv::Trial() {
  CheckInput(trial_ != nullptr, "there is no episode; call reset() first");
  CheckInput(!interrupted_, "the last step was interrupted; call reset() for a new episode");
  CheckInput(!terminated_ && !truncated_, "the episode has ended; call reset() for a new one");
  return *trial_;
}

const AttemptRecord& BinPickingEnv::Step(const std::optional<Grasp>& grasp) {
  PickingTrial& trial = Trial();
  LiveAttempt& attempt = trial.Attempt();
  attempt.RequireValid(grasp);
  const bool is_own = !attempt.IsChosen(grasp);
  interrupted_ = true;  // until the grasp was executed
  last_ = trial.Execute(grasp);
  interrupted_ = false;
  has_own_grasp_ |= is_own;
  truncated_ = trial.HasReachedLimit();
  terminated_ = trial.HasEnded() && !truncated_;
  if (trial.HasEnded()) {
    trials_.push_back(trial.TakeResult());
    own_grasps_ |= has_own_grasp_;
  } else {
    trial.Attempt();
  }
  return last_;
}

Grasp BinPickingEnv::GraspAt(const Pose& X_WG) const {
  const Gripper& tool = *setup_.tools.front();
  return {X_WG, tool.MaxOpening_m(), 1, kNoHypothesis, tool.name};
}

std::vector<PoseHypothesis> BinPickingEnv::Estimate() {
  std::vector<PoseHypothesis> hypotheses;
  for (const ScoredHypothesis& scored : Trial().Attempt().Estimate()) {
    hypotheses.push_back(scored.estimate);
  }
  return hypotheses;
}

const std::optional<Grasp>& BinPickingEnv::ChooseGrasp() { return Trial().Attempt().ChooseGrasp(); }

CapturedView BinPickingEnv::View() {
  CheckInput(trial_ != nullptr, "there is no episode; call reset() first");
  CheckInput(!interrupted_, "the last step was interrupted; call reset() for a new episode");
  if (final_view_) return *final_view_;
  const int number = trial_->attempts();
  const BinContent content{trial_->scene(), trial_->bin_index(), NamesOf(setup_.cell.objects())};
  if (!terminated_ && !truncated_) {
    const auto image = trial_->Attempt().image();
    return {{image, &image->view}, content, number, image->truth.instances()};
  }
  auto observation =
      std::make_shared<Observation>(setup_.cell.Capture(content.scene, content.bin_index, number));
  std::vector<TrueInstance> instances =
      InstancesOf(content.scene, observation->visible_fractions, setup_.cell.camera().X_CW());
  final_view_ = {std::move(observation), content, number, std::move(instances)};
  return *final_view_;
}

int BinPickingEnv::instances_left() const {
  return trial_ ? setup_.cell.WantedIn(trial_->scene()) : 0;
}

int BinPickingEnv::bin_index() const { return trial_ ? int{trial_->bin_index()} : next_bin_; }

int BinPickingEnv::attempt() const { return trial_ ? trial_->attempts() : 0; }

void BinPickingEnv::Write(const std::filesystem::path& folder) const {
  for (size_t i = 0; i < trials_.size(); ++i) {
    CheckInput(trials_[i].bin_index == static_cast<int>(i),
               fmt::format("the results of a run have the bins 0, 1, ..., but finished episode {} "
                           "has bin {}; end each episode, and reset with a seed before the first",
                           i, trials_[i].bin_index));
  }
  WriteRun(setup_.spec, scenario_->objects, trials_, own_grasps_, folder);
}

}  // namespace pickbed::eval
