#pragma once

// Counts for rates and paired errors, grouped by bin. Bins are the units of all statistics: the
// trials of one bin_index are one cluster, whatever the number of attempts, picks and instances.

#include <functional>
#include <span>
#include <vector>

#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "grasp/outcome.h"

namespace pickbed::eval {

// Returns each bin_index of the trials once, in ascending order.
std::vector<int> ScenesOf(std::span<const TrialResult> trials);

// Returns whether any attempt has a target: the trials are occlusion trials.
bool HasTargets(std::span<const TrialResult> trials);

// Adds the samples and successes of one trial to the cluster of its bin.
using TrialCount = std::function<void(const TrialResult& trial, Cluster& scene)>;
TrialCount SuccessOfAttempts();  // among executed grasps, by the scenario's success rule
// Counts executed grasps and their successes by `rule`.
TrialCount SuccessByRule(SuccessRule rule);
// Attempts that picked an instance, among all attempts; one without a grasp counts as a failure.
TrialCount AttemptsThatPicked();
TrialCount InstancesCleared();  // among the dropped instances
// Among the requested instances (eval/trial/instance_outcomes.h), or the dropped ones if a trial
// has no outcomes.
TrialCount RequestedCleared();
TrialCount TopRankedRight();  // among attempts with a hypothesis
// Recalled instances among all instances with a visible fraction in [min, max), or [min, max] if
// max is 1. If an attempt has a target, only the target counts. Attempts without a pose stage do
// not count.
TrialCount InstancesRecalled(double visible_min, double visible_max);
// Recalled instances among all instances in view with at least kCountedVisibility, whether they
// are targets or not.
TrialCount AllInstancesRecalled();
// Right poses among all reported poses. A pose is right if it recalls an instance, however little
// is visible of it; a second pose of an instance is not.
TrialCount PosesRight();
// Successes among executed grasps, by the visible fraction of the intended instance. This is the
// target if the attempt has one, else the instance that the executed pose matches.
TrialCount SuccessByVisibility(double visible_min, double visible_max);
// Successes among executed grasps at a fill level in [fill_min, fill_max). Attempts without a known
// fill level do not count.
TrialCount SuccessByFill(double fill_min, double fill_max);
// Successes among executed grasps on an instance of these layers, first_layer..last_layer, 1 = top.
TrialCount SuccessByLayer(int first_layer, int last_layer);
// Attempts that picked their target, among attempts with a target of this visible fraction. An
// attempt without a grasp counts as a failure.
TrialCount TargetsPicked(double visible_min, double visible_max);

// Returns one cluster for each element of `scenes`, in this order. `scenes` must be ascending.
// Trials of other bins are left out.
std::vector<Cluster> CountByScene(std::span<const TrialResult> trials,
                                  const std::vector<int>& scenes, const TrialCount& count);
// The same for all bins of the trials.
std::vector<Cluster> CountByScene(std::span<const TrialResult> trials, const TrialCount& count);

// Returns the error of a hypothesis to collect, such as its MSSD.
using ErrorOfPose = std::function<double(const HypothesisRecord& pose)>;
struct PairedErrors {
  ValueClusters before, after;  // by bin; equal positions are the same instance
};
// Returns the errors of two runs on the instances that both runs found. Otherwise a run that finds
// only easy instances would seem more accurate. Pairs have the same bin, attempt and instance. Each
// run contributes its highest-scored hypothesis that matches the instance (MSSD < 0.5 diameter). If
// an attempt has a target, only the target counts. A pair is left out if an error is not finite,
// for example a metric that one run did not record.
PairedErrors PairedErrorsByScene(std::span<const TrialResult> before,
                                 std::span<const TrialResult> after, const std::vector<int>& scenes,
                                 const ErrorOfPose& error);

}  // namespace pickbed::eval
