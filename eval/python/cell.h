#pragma once

// The cell of a scenario for Python: drop, capture, estimate, plan and execute, one call each.
// Every call gives the same result as the same stage of a trial of the program.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/trial/instance_matcher.h"
#include "eval/trial/observer.h"
#include "eval/trial/trial_records.h"
#include "eval/trial/trial_setup.h"
#include "grasp/execute/execute.h"
#include "perception/estimators/pose_estimator.h"
#include "scenes/base/ids.h"
#include "scenes/scenario/find_scenario.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Called during long work.
struct CallHooks {
  std::function<void()> on_wait;  // often; an exception ends the work
  std::function<void(const std::string& line)> on_warning;
};

// Calls on_wait after each stage of a trial and during motions.
class WaitObserver : public TrialObserver {
 public:
  explicit WaitObserver(const CallHooks& hooks) : hooks_(hooks) {}
  void OnStage(TrialStage, const AttemptState&) override { hooks_.on_wait(); }
  MotionListener ListenToMotion() override {
    return [this](const MotionState&) { hooks_.on_wait(); };
  }

 private:
  const CallHooks& hooks_;
};

// A settled bin. `object` of an instance is an index into Scenario.objects.
struct BinContent {
  Scene scene;
  BinIndex bin_index{0};
  std::vector<std::string> object_names;
};

// An image of a bin with its ground truth.
struct CapturedView {
  std::shared_ptr<const Observation> observation;
  BinContent content;
  int attempt = 0;                      // random streams of the image derive from it
  std::vector<TrueInstance> instances;  // in the camera frame, in the order of the bin's instances
};

// Picks one instance: the outcome of a grasp and the bin after it.
struct PickResult {
  GraspOutcome outcome;
  BinContent after;
};

// The simulated cell of a scenario: bin, camera, estimator, planner and gripper.
//
// Bins, images and random choices derive from the seed of the scenario. Attempt 0 of bin 0 is
// therefore the first attempt of `pickbed run` with the same scenario. An object belongs to the
// thread that made it.
class Cell {
 public:
  // Loads the sensor and prepares the objects. The estimator, the grasp candidates and the planner
  // are made on first use. Throws InputError, see SimulatedCell.
  Cell(std::shared_ptr<const LoadedScenario> scenario, CallHooks hooks);

  // Drops the instances of a bin and waits until they are at rest. Throws InputError if the bin
  // stays refused, see sim/drop/certified_scene.h.
  BinContent Drop(BinIndex bin_index);
  // Captures one image with the noise of the sensor. Each `attempt` has its own random stream.
  CapturedView Capture(const BinContent& content, int attempt);
  // Estimates the poses with the estimator of the scenario. Every estimator can be used, also
  // "oracle". The hypotheses are ranked by score.
  EstimateResult Estimate(const CapturedView& view);
  // Estimates the poses in any image of the objects, for example a real one. `camera` has the pose
  // X_WC of the camera; the bin is assumed at the world frame. `seed` is for estimators with random
  // choices. Throws InputError for the estimator "oracle", which needs ground truth.
  EstimateResult EstimateFrame(const RgbdFrame& frame, const Camera& camera, uint64_t seed);
  // Compares hypotheses with the true instances, as a trial does. Throws InputError for an unknown
  // object.
  std::vector<HypothesisRecord> Score(const CapturedView& view,
                                      const std::vector<PoseHypothesis>& hypotheses);
  // Plans grasps with the planner of the scenario; best first. `hypotheses` are not used by a
  // planner without poses. Throws InputError for an unknown object.
  PlanResult Plan(const CapturedView& view, const std::vector<PoseHypothesis>& hypotheses,
                  int max_grasps);
  // Executes a grasp in a copy of the bin, with the robot errors of `attempt`. The index of a
  // hypothesis in the grasp refers to `hypotheses`; its nearest instance is the target. Without one
  // (-1), any instance is the target. A failed grasp is a result. Throws InputError for an unknown
  // hypothesis, object or tool.
  PickResult Execute(const BinContent& content, const Grasp& grasp,
                     const std::vector<PoseHypothesis>& hypotheses, int attempt);

  // Runs the whole trial of a bin, as `pickbed run` does.
  TrialResult RunTrial(BinIndex bin_index);

  // Bin of the scenario.
  const Bin& bin() const { return cell_.bin(); }
  // True camera. An image has the camera that the cell assumes, which differs if the cell has
  // errors.
  const Camera& camera() const { return cell_.camera(); }
  // Objects as in CAD.
  const ObjectSet& objects() const { return cell_.objects(); }

 private:
  TrialSetup& Setup();
  void RequireKnown(const std::vector<PoseHypothesis>& hypotheses) const;
  void RequireOwn(const BinContent& content) const;
  BinContent ContentOf(Scene scene, BinIndex bin_index) const;

  std::shared_ptr<const LoadedScenario> scenario_;
  CallHooks hooks_;
  SimulatedCell cell_;
  std::unique_ptr<TrialSetup> setup_;  // null until it is needed
};

// Returns the names of the objects, by index.
std::vector<std::string> NamesOf(const ObjectSet& objects);

// Returns trial options that call the hooks and make the estimator on demand.
TrialOptions OptionsWith(const CallHooks& hooks);

}  // namespace pickbed::eval
