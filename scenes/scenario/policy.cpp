#include "scenes/scenario/policy.h"

#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

bool FailedTooOften(const PolicyState& state, const PolicySpec& policy) {
  return state.failures_in_row >= policy.max_failures_in_row;
}

bool NoGraspOrFailedTooOften(const PolicyState& state, const PolicySpec& policy) {
  return !state.grasp_found || FailedTooOften(state, policy);
}

bool Never(const PolicyState&, const PolicySpec&) { return false; }

constexpr PolicyRow kPolicies[] = {
    // Clutter removal as in the VGN paper (Breyer et al. 2020), with two failures in a row.
    {"until_empty",
     "until the bin is empty, no grasp is found, or max_failures_in_row attempts fail",
     NoGraspOrFailedTooOften},
    {"capture_again",
     "like until_empty, but an attempt that finds no grasp only counts as a failure",
     FailedTooOften},
    {"one_pick", "one attempt in each bin", Never, 1},
};

std::vector<std::string> Names() {
  std::vector<std::string> names;
  for (const PolicyRow& row : kPolicies) names.push_back(row.name);
  return names;
}

}  // namespace

void StirSpec::Visit(SettingsVisitor& v) {
  v.Integer("max", max, {0, 1000},
            "maximum number of times in a trial that the closed hand stirs the bin, 0 = never");
  v.Integer("after", after, {1, 1000},
            "number of consecutive attempts without a grasp after which the bin is stirred");
  v.Integer("after_failures", after_failures, {0, 1000},
            "number of failed attempts since the last success or stir after which the bin is "
            "stirred instead of another attempt, 0 = only without a grasp");
}

void PolicySpec::Visit(SettingsVisitor& v) {
  v.RenamedValue("stop", "look_again", "capture_again");
  v.Text("stop", stop, Names(), "rule that ends a trial, a row of `pickbed list policies`");
  v.Integer("max_failures_in_row", max_failures_in_row, {1, 1000},
            "number of consecutive failed attempts that ends a trial");
  v.RenamedKey("max_picks", "max_attempts");
  v.Integer("max_attempts", max_attempts, {0, 100000},
            "maximum number of attempts in a trial, 0 = no limit");
  v.Integer(
      "max_failures_at_place", max_failures_at_place, {0, 1000},
      "number of failed grasps at a place after which no grasp within 40 mm is executed until "
      "the bin is stirred, 0 = no limit");
  v.Integer("picks_per_image", picks_per_image, {1, 100},
            "maximum number of picks after one image; only picks that cannot disturb each other");
  v.Text("ranking", ranking, {},
         "criterion that orders the grasps without collision, a row of `pickbed list rankings`");
  v.Text(
      "tolerance_maps", tolerance_maps, {},
      "folder of the tolerance maps of all objects with the gripper; only for ranking tolerance");
  v.Real("pose_error_mm", pose_error_mm, {0, 100},
         "expected standard deviation of an estimated position, each axis, mm; only for ranking "
         "tolerance");
  v.Real("pose_error_deg", pose_error_deg, {0, 180},
         "expected standard deviation of an estimated rotation, degrees; only for ranking "
         "tolerance");
  v.Bool("check_lift", check_lift,
         "whether grasps are rejected whose object would meet a wall of the bin while lifted");
  v.Real("lift_clearance_mm", lift_clearance_mm, {-100, 1000},
         "distance of the lifted object from the walls, mm; only with check_lift; negative allows "
         "an overlap of erroneous poses");
  v.Real("retention_g", retention_g, {0, 100},
         "largest load of a hold test after each successful pick, multiples of g; 0 = no test");
  v.Text("retention_load", retention_load, {"weight", "lateral"},
         "whether the weight grows in the hold test, or a horizontal load across the fingers");
  v.Group(
      "stir", [this](SettingsVisitor& g) { stir.Visit(g); },
      "pushing through the clutter if no grasp is found");
  v.RenamedValue("success", "right_part", "right_instance");
  v.Text("success", success, {},
         "rule that decides whether an attempt succeeds, a row of `pickbed list rules`");
}

void CycleSpec::Visit(SettingsVisitor& v) {
  v.Real("sense_s", sense_s, {0, 3600}, "time to capture one image, s");
  v.Real("compute_s", compute_s, {0, 3600},
         "time to estimate and plan for one image, s; 0 = as measured");
  v.Real("move_s", move_s, {0, 3600},
         "time for one pick: approach, transport to the place and return, s");
  v.Real("tool_change_s", tool_change_s, {0, 3600},
         "time to change the gripper between two picks, s");
  v.Bool("overlap", overlap,
         "whether the next image is captured and computed while the arm moves outside the bin");
  v.Real("in_bin_s", in_bin_s, {0, 3600},
         "time of a pick in which the arm hides the bin, s; only with overlap");
}

std::span<const PolicyRow> PolicyTable() { return kPolicies; }

const PolicyRow& PolicyNamed(const std::string& name) {
  for (const PolicyRow& row : kPolicies) {
    if (name == row.name) return row;
  }
  throw InputError(UnknownNameMessage("policy", name, Names()));
}

}  // namespace pickbed::scenes
