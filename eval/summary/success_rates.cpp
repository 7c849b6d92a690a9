#include "eval/summary/success_rates.h"

#include <fmt/format.h>

#include <numbers>

#include "eval/trial/counts_by_bin.h"

namespace pickbed::eval {
namespace {

// Visits all columns: name and value. One list serves header and cells.
template <typename V>
void VisitCells(const GraspOutcome& o, V&& v) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    v(row.name, static_cast<int>(o.verdicts[static_cast<int>(row.rule)]));
  }
  v("picked_instance", o.picked_instance);
  v("instances_touched", o.instances_touched);
  v("instances_lifted", o.instances_lifted);
  v("lift_height_mm", 1e3 * o.lift_height_m);
  v("opening_mm", 1e3 * o.final_opening_m);
  v("force_x_n", o.contact_force_n.x());
  v("force_y_n", o.contact_force_n.y());
  v("force_z_n", o.contact_force_n.z());
  v("torque_x_nm", o.contact_torque_nm.x());
  v("torque_y_nm", o.contact_torque_nm.y());
  v("torque_z_nm", o.contact_torque_nm.z());
  v("place_error_mm", 1e3 * o.place_error_m);
  v("place_rotation_error_deg", kDegrees * o.place_rotation_error_rad);
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
    rate.executed_grasps = sum.samples;
    rate.ci95 = ClusterInterval(scenes);
  }
  return rates;
}

std::string OutcomeHeader() {
  std::string header;
  VisitCells({}, [&](const char* name, auto) { header += fmt::format(",{}", name); });
  return header;
}

std::string OutcomeCells(const AttemptRecord& attempt) {
  std::string cells;
  const bool is_placing = attempt.outcome.place_executed;
  VisitCells(attempt.outcome, [&](std::string_view name, auto value) {
    const bool is_known = attempt.grasp && (is_placing || !name.starts_with("place_"));
    cells += is_known ? fmt::format(",{}", value) : ",";
  });
  return cells;
}

}  // namespace pickbed::eval
