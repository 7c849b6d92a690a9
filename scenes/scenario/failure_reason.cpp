#include "scenes/scenario/failure_reason.h"

#include <array>

namespace pickbed::scenes {
namespace {

constexpr std::array kFailures{
    FailureRow{FailureReason::kNone, Stage::kDone, "none", "the pick succeeded"},
    FailureRow{FailureReason::kNotVisible, Stage::kSense, "not_visible",
               "the camera saw too little of any part"},
    FailureRow{FailureReason::kNoProposal, Stage::kDetect, "no_proposal",
               "parts in view, none was proposed"},
    FailureRow{FailureReason::kWrongObject, Stage::kDetect, "wrong_object",
               "the pose names another object than the one at this place", "wrong_part"},
    FailureRow{FailureReason::kPoseWrong, Stage::kPose, "pose_wrong",
               "the pose was off by 0.1 diameter or more"},
    FailureRow{FailureReason::kRefinementWorse, Stage::kRefine, "refinement_worse",
               "refinement made a right pose wrong"},
    FailureRow{FailureReason::kSuppressed, Stage::kRefine, "suppressed",
               "a right pose was suppressed"},
    FailureRow{FailureReason::kNoGrasp, Stage::kPlan, "no_grasp",
               "no collision-free grasp for any pose"},
    FailureRow{FailureReason::kCollision, Stage::kApproach, "collision",
               "the hand hit something on its way"},
    FailureRow{FailureReason::kClosedOnNothing, Stage::kGrasp, "closed_on_nothing",
               "the fingers met, or the cup did not seal"},
    FailureRow{FailureReason::kSlipped, Stage::kGrasp, "slipped",
               "the part left the fingers while lifting"},
    FailureRow{FailureReason::kDropped, Stage::kGrasp, "dropped",
               "the part was lost while holding or shaking"},
    FailureRow{FailureReason::kMisplaced, Stage::kGrasp, "misplaced",
               "brought, but not set down as it was to lie"},
    FailureRow{FailureReason::kDoublePick, Stage::kGrasp, "double_pick",
               "another instance came with the target, or instead of it", "took_two"},
    FailureRow{FailureReason::kNeighborDisplaced, Stage::kGrasp, "neighbor_displaced",
               "the instance left the bin in a pick of another one", "disturbed"},
    FailureRow{FailureReason::kPhysicsFailed, Stage::kSimulate, "physics_failed",
               "bodies exploded or the solver gave NaN"},
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
