#pragma once

// The picking environment of Python: trials of a scenario, step by step, with grasps that the
// caller chooses. For the same grasps, its records are equal to the records of the program.

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "eval/python/cell.h"
#include "eval/trial/attempt.h"
#include "eval/trial/trial.h"

namespace pickbed::eval {

// Bin picking as an environment for learning agents, with the interface of Gymnasium but without
// the package. An episode is one bin, a step is one grasp.
//
// reset() drops a bin. step(grasp) executes the grasp in physics and captures the next image. The
// episode ends when the bin is empty or the policy of the scenario gives up. The observation is a
// dict with "color" (height x width x 3, uint8), "depth_m" (height x width, float32, metres along
// the camera's z axis, 0 = no reading), "K" (3 x 3) and "X_WC" (4 x 4, pose of the camera in the
// world). The reward is 1 for a successful pick, else 0. The dict `info` has the bin index, the
// number of the attempt, the number of instances left and, after a step, the AttemptRecord.
//
// With the grasps of choose_grasp(), the records are equal to the records of `pickbed run` with the
// same scenario and seed, byte by byte.
class BinPickingEnv {
 public:
  // Prepares the cell, the gripper and the planner of the scenario. The estimator is made when an
  // attempt first needs it. Throws InputError as `pickbed run`, and for an occlusion scenario.
  BinPickingEnv(std::shared_ptr<const LoadedScenario> scenario, CallHooks hooks);
  ~BinPickingEnv();

  // Drops a bin and captures the first image. With a seed, the next bin is bin 0 of the scenario
  // with this seed, and earlier records are dropped. Without one, it is the bin after the last one.
  // A bin index given as options={"bin_index": 3} is used instead. An unfinished episode leaves no
  // record.
  void Reset(std::optional<uint64_t> seed, std::optional<int> bin_index);

  // Executes a grasp and captures the next image. The grasp is a Grasp, the 4 x 4 pose X_WG of the
  // hand, or None: no grasp was found. The record is the last attempt. Throws InputError without an
  // episode, and as LiveAttempt::Execute().
  const AttemptRecord& Step(const std::optional<Grasp>& grasp);

  // Returns a grasp at this pose of the hand, with the first gripper fully open and without a
  // hypothesis.
  Grasp GraspAt(const Pose& X_WG) const;

  // Estimates the poses in the present image with the estimator of the scenario. Returns the
  // hypotheses. A grasp refers to one of them by its index.
  std::vector<PoseHypothesis> Estimate();
  // Returns the grasp that the estimator and the planner of the scenario choose, or None if there
  // is none. It does not repeat failed grasps.
  const std::optional<Grasp>& ChooseGrasp();

  // The present image with its ground truth. After the last step of an episode, it shows the bin as
  // it was left.
  CapturedView View();
  // The last step emptied the bin, or the policy gave up.
  bool terminated() const { return terminated_; }
  // The last step was the last one that `policy.max_attempts` allows.
  bool truncated() const { return truncated_; }
  // Number of wanted instances in the bin.
  int instances_left() const;
  // Number of the bin in the scenario.
  int bin_index() const;
  // Number of the attempt under way.
  int attempt() const;

  // Records of the finished episodes since the last reset with a seed.
  const std::vector<TrialResult>& trials() const { return trials_; }
  // Writes the finished episodes as the results folder of a run, for `pickbed report`, `compare`
  // and the other commands. Their bins must be 0, 1, ... Throws InputError without episodes, and if
  // the folder cannot be written or holds results.
  void Write(const std::filesystem::path& folder) const;

 private:
  PickingTrial& Trial();

  std::shared_ptr<const LoadedScenario> scenario_;
  CallHooks hooks_;
  WaitObserver observer_;
  TrialSetup setup_;
  std::unique_ptr<PickingTrial> trial_;  // null: no episode
  bool interrupted_ = false;             // an exception ended a step
  bool terminated_ = false, truncated_ = false;
  AttemptRecord last_;
  std::optional<CapturedView> final_view_;
  std::vector<TrialResult> trials_;
  bool has_own_grasp_ = false;  // in the episode
  bool own_grasps_ = false;     // in one of trials_
  int next_bin_ = 0;
};

}  // namespace pickbed::eval
