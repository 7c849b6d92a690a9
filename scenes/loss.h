#pragma once

// The one list of what can become of a pick, used by console, JSON, store and report. Every lost
// pick is charged to one reason, and every reason belongs to one stage.

#include <optional>
#include <span>
#include <string_view>

namespace pickbed {

enum class Stage { kDone, kSense, kDetect, kPose, kRefine, kPlan, kApproach, kGrasp, kSimulate };

enum class Loss {
  kNone,             // the pick succeeded
  kNotVisible,       // the camera saw too little of any part
  kNoProposal,       // parts in view, no hypothesis reported
  kWrongPart,        // hypothesis names another part than the one that lies there
  kPoseWrong,        // wrong, and no stage had a right one in its place
  kRefinementWorse,  // refinement made a right pose wrong
  kSuppressed,       // a right pose was suppressed
  kNoGrasp,          // no collision-free grasp for any hypothesis
  kCollision,        // gripper hit something on approach
  kClosedOnNothing,  // fingers met, or a cup did not seal
  kSlipped,          // part left the fingers while lifting
  kDropped,          // part lost while holding or shaking
  kMisplaced,        // brought, but not set down as it was to lie; where that decides
  kTookTwo,          // another part came too, or in place of the one that was meant
  kDisturbed,        // part left the bin by a pick that was not meant for it
  kPhysicsFailed,    // bodies exploded or the solver gave NaN
};

struct LossRow {
  Loss loss;
  Stage stage;
  std::string_view name;  // stable key in JSON, CSV and the store
  std::string_view help;  // one line
};

std::span<const LossRow> LossTable();
std::string_view LossName(Loss loss);
std::string_view StageName(Stage stage);
Stage StageOf(Loss loss);
std::optional<Loss> LossFromName(std::string_view name);

}  // namespace pickbed
