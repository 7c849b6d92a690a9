#include "eval/summary/setting_notes.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "eval/cell/visible_size.h"
#include "eval/trial/oracle_estimator.h"
#include "grasp/planners/table.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {
namespace {

// Settings whose key begins with `prefix`, and why they are not used. "estimator.mode" is also the
// begin of estimator.model.
struct UnusedRow {
  std::string_view prefix;
  bool is_unused = false;
  std::string why;
};

std::vector<UnusedRow> RowsOf(const ScenarioSpec& spec) {
  const PolicySpec& policy = spec.policy;
  const bool has_poses = NeedsPoses(spec);
  const bool is_oracle = has_poses && !LoadsEstimator(spec);
  const std::string without_poses =
      fmt::format("planner {} works without poses", spec.planner.name);
  const std::string oracle = "the oracle takes poses from the scene";
  const std::string other_ranking = fmt::format("policy.ranking is {}", policy.ranking);
  return {
      {"estimator.", !has_poses, without_poses},
      {"refiner", !has_poses, without_poses},
      {"estimator.mode", is_oracle, oracle},
      {"policy.stir.after", policy.stir.max == 0, "policy.stir.max is 0"},
      {"policy.stir.", policy.stir.max > 0 && policy.stop == "one_pick",
       "policy.stop is one_pick, so a trial ends before a stir"},
      {"policy.tolerance_maps", policy.ranking != "tolerance", other_ranking},
      {"policy.pose_error_", policy.ranking != "tolerance", other_ranking},
      {"policy.lift_clearance_mm", !policy.check_lift, "policy.check_lift is false"},
      {"cycle.in_bin_s", !spec.cycle.overlap, "cycle.overlap is false"},
  };
}

}  // namespace

bool NeedsPoses(const ScenarioSpec& spec) {
  return WithSettingsKey(spec, "planner.name",
                         [&] { return PlannerNamed(spec.planner.name).needs_poses; });
}

std::string UnusedSettings(const ScenarioSpec& spec) {
  std::string notes;
  for (const UnusedRow& row : RowsOf(spec)) {
    if (!row.is_unused) continue;
    for (const auto& [key, place] : spec.places) {
      // A preset may have settings for an estimator that the command line replaces.
      const bool is_from_user = place.starts_with(kAssignmentPlace);
      if (!is_from_user || !key.starts_with(row.prefix)) continue;
      notes += fmt::format("note: {} is not used: {}\n", place, row.why);
    }
  }
  return notes;
}

bool LoadsEstimator(const ScenarioSpec& spec) {
  return NeedsPoses(spec) && spec.estimator.name != kOracleName;
}

std::string SmallObjectNote(const ScenarioSpec& spec, const ObjectSet& objects) {
  const std::string text = TooSmallText(spec, objects);
  return text.empty() ? text : fmt::format("note: {}\n", text);
}

}  // namespace pickbed::eval
