#pragma once

// Trials as what their scenes add to rates and errors. Scenes are the units of all statistics:
// trials of one scene number are one cluster, whatever its number of looks, picks and instances.

#include <functional>
#include <span>
#include <vector>

#include "eval/statistics.h"
#include "eval/trial.h"
#include "grasp/success_rules.h"

namespace pickbed {

// Scene numbers of the trials, ascending, each once.
std::vector<int> ScenesOf(std::span<const TrialResult> trials);

// Adds what a trial tells of a rate.
using TrialCount = std::function<void(const TrialResult& trial, Cluster& scene)>;
TrialCount SuccessOfAttempts();  // by the scenario's rule, of executed grasps
TrialCount SuccessByRule(SuccessRule rule);
TrialCount PartsCleared();    // of those that were dropped
TrialCount TopRankedRight();  // of looks with a hypothesis
// Instances that are recalled, of those whose visible fraction lies in [min, max), or [min, max]
// where max is 1. Of a look about a target it is the target alone.
TrialCount InstancesRecalled(double visible_min, double visible_max);
// Successes of executed grasps by the visible fraction of the part that was aimed at: the target of
// a look that has one, else the instance that the executed pose stands on.
TrialCount SuccessByVisibility(double visible_min, double visible_max);
// Looks about a target of that visible fraction that brought it; one that found no grasp did not.
TrialCount TargetsPicked(double visible_min, double visible_max);

// A cluster a scene, in the order of `scenes` (ascending); trials of other scenes are left out.
std::vector<Cluster> CountByScene(std::span<const TrialResult> trials,
                                  const std::vector<int>& scenes, const TrialCount& count);
// Of all scenes of the trials.
std::vector<Cluster> CountByScene(std::span<const TrialResult> trials, const TrialCount& count);

// What is collected of a hypothesis, such as its MSSD.
using ErrorOfPose = std::function<double(const HypothesisScore& pose)>;
struct PairedErrors {
  ValueClusters before, after;  // by scene; value by value of the same instances
};
// Errors of two runs on the instances that both found, so that a run that finds easy parts alone
// doesn't look the more exact one: the same instance in the same look of the same scene, each with
// the hypothesis of the highest score among those that stand on it (MSSD < 0.5 diameter). Of a look
// about a target it is the target alone.
PairedErrors PairedErrorsByScene(std::span<const TrialResult> before,
                                 std::span<const TrialResult> after, const std::vector<int>& scenes,
                                 const ErrorOfPose& error);

}  // namespace pickbed
