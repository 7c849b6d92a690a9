#pragma once

// The list of failure reasons of a pick, used by console, JSON, store and report. Every failed pick
// has one reason, and every reason belongs to one stage.

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace pickbed::scenes {

// Stage of an attempt; kDone means success.
enum class Stage { kDone, kSense, kDetect, kPose, kRefine, kPlan, kApproach, kGrasp, kSimulate };

// Failure reason of a pick.
enum class FailureReason {
  kNone,               // the pick succeeded
  kNotVisible,         // the visible fraction of every instance was too small
  kNoProposal,         // instances were visible, but no hypothesis was reported
  kWrongObject,        // the hypothesis names another object than the one at this place
  kPoseWrong,          // the pose was wrong, and no stage had a correct one for it
  kRefinementWorse,    // refinement made a correct pose wrong
  kSuppressed,         // a correct pose was suppressed
  kNoGrasp,            // no hypothesis had a collision-free grasp
  kCollision,          // the gripper hit something on the approach
  kClosedOnNothing,    // the fingers met, or a cup did not seal
  kSlipped,            // the instance left the fingers while lifting
  kDropped,            // the instance was lost while holding or shaking
  kMisplaced,          // delivered in a wrong pose; only where the success rule requires the pose
  kDoublePick,         // another instance came with the target, or instead of it
  kNeighborDisplaced,  // an instance left the bin in a pick of another one
  kPhysicsFailed,      // bodies exploded or the solver gave NaN
  // Last, so that the numbers in the hashes of earlier results stay the same.
  kStirred,           // no grasp was found, and the closed hand stirred the bin
  kEntangled,         // another instance was lifted with the target without contact to the hand
  kEstimatorCrashed,  // the program of the estimator ended, failed, or gave a wrong answer
  kEstimatorTimeout,  // the program of the estimator gave no answer in time
  kPlannerCrashed,    // the program of the planner ended, failed, or gave a wrong answer
  kPlannerTimeout,    // the program of the planner gave no answer in time
};
inline constexpr size_t kFailureReasons = static_cast<size_t>(FailureReason::kPlannerTimeout) + 1;

// Returns whether a program of the user, an estimator or a planner, caused the failure.
constexpr bool ProgramFailed(FailureReason failure) {
  return failure == FailureReason::kEstimatorCrashed ||
         failure == FailureReason::kEstimatorTimeout || failure == FailureReason::kPlannerCrashed ||
         failure == FailureReason::kPlannerTimeout;
}

// A row of the table of failure reasons.
struct FailureRow {
  FailureReason failure;
  Stage stage;
  std::string_view name;              // stable key in JSON, CSV and the store
  std::string_view help;              // one line
  std::string_view former_name = {};  // in files of earlier versions; empty if unchanged
};

// Returns one row per failure reason, in the order of the enumeration.
std::span<const FailureRow> FailureTable();
// Returns FailureRow::name.
std::string_view FailureName(FailureReason failure);
// Returns the stable name of a stage in JSON, CSV and the store.
std::string_view StageName(Stage stage);
// Returns FailureRow::stage.
Stage StageOf(FailureReason failure);
// Returns the failure reason with this name or former name in FailureTable(), or nullopt if there
// is none.
std::optional<FailureReason> FailureFromName(std::string_view name);

}  // namespace pickbed::scenes
