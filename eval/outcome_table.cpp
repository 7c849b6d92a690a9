#include "eval/outcome_table.h"

#include <fmt/format.h>

#include <numbers>

#include "eval/trial_clusters.h"

namespace pickbed {
namespace {

// Every column once: its name, and what it is of an outcome.
template <typename V>
void VisitCells(const GraspOutcome& o, V&& v) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    v(row.name, static_cast<int>(o.verdicts[static_cast<int>(row.rule)]));
  }
  v("picked_instance", o.picked_instance);
  v("parts_touched", o.parts_touched);
  v("parts_lifted", o.parts_lifted);
  v("lift_height_mm", 1e3 * o.lift_height_m);
  v("opening_mm", 1e3 * o.final_opening_m);
  v("force_x_n", o.contact_force_n.x());
  v("force_y_n", o.contact_force_n.y());
  v("force_z_n", o.contact_force_n.z());
  v("torque_x_nm", o.contact_torque_nm.x());
  v("torque_y_nm", o.contact_torque_nm.y());
  v("torque_z_nm", o.contact_torque_nm.z());
  v("place_error_mm", 1e3 * o.place_error_m);
  v("place_turn_deg", kDegrees * o.place_turn_rad);
}

}  // namespace

std::array<RuleRate, kSuccessRules> RatesByRule(const std::vector<TrialResult>& trials) {
  std::array<RuleRate, kSuccessRules> rates;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    RuleRate& rate = rates[static_cast<int>(row.rule)];
    rate.rule = row.rule;
    const std::vector<Cluster> scenes = CountByScene(trials, SuccessByRule(row.rule));
    const Cluster sum = SumOf(scenes);
    rate.successes = sum.hits;
    rate.attempts = sum.tries;
    rate.ci95 = ClusterInterval(scenes);
  }
  return rates;
}

std::string OutcomeHeader() {
  std::string header;
  VisitCells({}, [&](const char* name, auto) { header += fmt::format(",{}", name); });
  return header;
}

std::string OutcomeCells(const PickRecord& pick) {
  std::string cells;
  const bool is_placing = pick.outcome.set_down;
  VisitCells(pick.outcome, [&](std::string_view name, auto value) {
    const bool is_known = pick.grasp && (is_placing || !name.starts_with("place_"));
    cells += is_known ? fmt::format(",{}", value) : ",";
  });
  return cells;
}

}  // namespace pickbed
