#include "scenes/loss.h"

#include <array>

namespace pickbed {
namespace {

constexpr std::array kLosses{
    LossRow{Loss::kNone, Stage::kDone, "none", "the pick succeeded"},
    LossRow{Loss::kNotVisible, Stage::kSense, "not_visible",
            "the camera saw too little of any part"},
    LossRow{Loss::kNoProposal, Stage::kDetect, "no_proposal", "parts in view, none was proposed"},
    LossRow{Loss::kWrongPart, Stage::kDetect, "wrong_part",
            "the pose names another part than lies there"},
    LossRow{Loss::kPoseWrong, Stage::kPose, "pose_wrong",
            "the pose was off by 0.1 diameter or more"},
    LossRow{Loss::kRefinementWorse, Stage::kRefine, "refinement_worse",
            "refinement made a right pose wrong"},
    LossRow{Loss::kSuppressed, Stage::kRefine, "suppressed", "a right pose was suppressed"},
    LossRow{Loss::kNoGrasp, Stage::kPlan, "no_grasp", "no collision-free grasp for any pose"},
    LossRow{Loss::kCollision, Stage::kApproach, "collision", "the hand hit something on its way"},
    LossRow{Loss::kClosedOnNothing, Stage::kGrasp, "closed_on_nothing",
            "the fingers met, or the cup did not seal"},
    LossRow{Loss::kSlipped, Stage::kGrasp, "slipped", "the part left the fingers while lifting"},
    LossRow{Loss::kDropped, Stage::kGrasp, "dropped", "the part was lost while holding or shaking"},
    LossRow{Loss::kMisplaced, Stage::kGrasp, "misplaced",
            "brought, but not set down as it was to lie"},
    LossRow{Loss::kTookTwo, Stage::kGrasp, "took_two", "another part came too, or instead"},
    LossRow{Loss::kDisturbed, Stage::kGrasp, "disturbed",
            "the part left the bin by a pick that was not meant for it"},
    LossRow{Loss::kPhysicsFailed, Stage::kSimulate, "physics_failed",
            "bodies exploded or the solver gave NaN"},
};

const LossRow& RowOf(Loss loss) { return kLosses.at(static_cast<size_t>(loss)); }

}  // namespace

std::span<const LossRow> LossTable() { return kLosses; }

std::string_view LossName(Loss loss) { return RowOf(loss).name; }

Stage StageOf(Loss loss) { return RowOf(loss).stage; }

std::string_view StageName(Stage stage) {
  constexpr std::array<std::string_view, 9> names{"done", "sense",    "detect", "pose",    "refine",
                                                  "plan", "approach", "grasp",  "simulate"};
  return names.at(static_cast<size_t>(stage));
}

std::optional<Loss> LossFromName(std::string_view name) {
  for (const LossRow& row : kLosses) {
    if (row.name == name) return row.loss;
  }
  return std::nullopt;
}

}  // namespace pickbed
