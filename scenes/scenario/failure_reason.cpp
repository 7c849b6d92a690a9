#include "scenes/scenario/failure_reason.h"

#include <array>

namespace pickbed::scenes {
namespace {

constexpr std::array kFailures{
    FailureRow{FailureReason::kNone, Stage::kDone, "none", "the attempt succeeded"},
    FailureRow{FailureReason::kNotVisible, Stage::kSense, "not_visible",
               "too little of every instance was visible"},
    FailureRow{FailureReason::kNoProposal, Stage::kDetect, "no_proposal",
               "instances were visible, but no pose was proposed"},
    FailureRow{FailureReason::kWrongObject, Stage::kDetect, "wrong_object",
               "the pose names another object than the one at this position", "wrong_part"},
    FailureRow{FailureReason::kPoseWrong, Stage::kPose, "pose_wrong",
               "the pose error was 0.1 diameter or more"},
    FailureRow{FailureReason::kRefinementWorse, Stage::kRefine, "refinement_worse",
               "refinement changed a right pose to a wrong one"},
    FailureRow{FailureReason::kSuppressed, Stage::kRefine, "suppressed",
               "non-maximum suppression removed a right pose"},
    FailureRow{FailureReason::kNoGrasp, Stage::kPlan, "no_grasp",
               "no pose had a grasp without collision"},
    FailureRow{FailureReason::kCollision, Stage::kApproach, "collision",
               "the hand hit an obstacle on its way"},
    FailureRow{FailureReason::kClosedOnNothing, Stage::kGrasp, "closed_on_nothing",
               "the fingers closed empty, or the cup did not seal"},
    FailureRow{FailureReason::kSlipped, Stage::kGrasp, "slipped",
               "the instance slipped out of the hand during the lift"},
    FailureRow{FailureReason::kDropped, Stage::kGrasp, "dropped",
               "the instance was lost during the hold or the shake"},
    FailureRow{FailureReason::kMisplaced, Stage::kGrasp, "misplaced",
               "the instance was carried out but not set down at the planned pose"},
    FailureRow{FailureReason::kDoublePick, Stage::kGrasp, "double_pick",
               "another instance came out in the hand with the target, or instead of it",
               "took_two"},
    FailureRow{FailureReason::kNeighborDisplaced, Stage::kGrasp, "neighbor_displaced",
               "the instance left the bin in an attempt on another one", "disturbed"},
    FailureRow{FailureReason::kPhysicsFailed, Stage::kSimulate, "physics_failed",
               "the physics failed: bodies moved too fast, or the solver gave NaN"},
    FailureRow{FailureReason::kStirred, Stage::kPlan, "stirred",
               "no pose had a grasp without collision, and the closed hand stirred the bin"},
    FailureRow{FailureReason::kEntangled, Stage::kGrasp, "entangled",
               "another instance was hooked on the target and came out without touching the hand"},
    FailureRow{FailureReason::kEstimatorCrashed, Stage::kDetect, "estimator_crashed",
               "the program of the estimator ended, failed, or gave a wrong answer"},
    FailureRow{FailureReason::kEstimatorTimeout, Stage::kDetect, "estimator_timeout",
               "the program of the estimator gave no answer in time"},
    FailureRow{FailureReason::kPlannerCrashed, Stage::kPlan, "planner_crashed",
               "the program of the planner ended, failed, or gave a wrong answer"},
    FailureRow{FailureReason::kPlannerTimeout, Stage::kPlan, "planner_timeout",
               "the program of the planner gave no answer in time"},
};

const FailureRow& RowOf(FailureReason failure) {
  return kFailures.at(static_cast<size_t>(failure));
}

}  // namespace

std::span<const FailureRow> FailureTable() { return kFailures; }

std::string_view FailureName(FailureReason failure) { return RowOf(failure).name; }

Stage StageOf(FailureReason failure) { return RowOf(failure).stage; }

std::string_view StageName(Stage stage) {
  constexpr std::array<std::string_view, 9> names{"done", "sense",    "detect", "pose",    "refine",
                                                  "plan", "approach", "grasp",  "simulate"};
  return names.at(static_cast<size_t>(stage));
}

std::optional<FailureReason> FailureFromName(std::string_view name) {
  if (name.empty()) return std::nullopt;
  for (const FailureRow& row : kFailures) {
    if (row.name == name || row.former_name == name) return row.failure;
  }
  return std::nullopt;
}

}  // namespace pickbed::scenes
