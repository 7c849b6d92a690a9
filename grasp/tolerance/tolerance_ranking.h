#pragma once

// Values of grasp candidates for the ranking "tolerance".

#include <span>
#include <string>
#include <vector>

#include "grasp/grasp.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::grasp {

inline constexpr char kToleranceRanking[] = "tolerance";

// Fills GraspCandidate::tolerance of all candidates (by object) if the scenario ranks by it, with
// the models in policy.tolerance_maps. Throws InputError if an object with candidates has no model
// for this gripper.
void FillTolerance(const ScenarioSpec& spec, const ObjectSet& objects, const std::string& gripper,
                   std::vector<std::vector<GraspCandidate>>& candidates);

// Returns the content of the models that the scenario ranks by, for the identity of a run; empty
// for another ranking. Throws InputError if they cannot be read.
std::string ToleranceRankingText(const ScenarioSpec& spec);

}  // namespace pickbed::grasp
