#include "eval/summary/success_rates.h"

#include <fmt/format.h>

#include "eval/trial/counts_by_bin.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

// Visits all columns: name, help and value. One list serves header and cells.
template <typename V>
void VisitCells(const GraspOutcome& o, V&& v) {
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    v(row.name, fmt::format("1 if the grasp succeeds by this rule: {}", row.help),
      static_cast<int>(o.verdicts[static_cast<int>(row.rule)]));
  }
  v("picked_instance", "instance in the hand at the end, -1 = none", o.picked_instance);
  v("instances_touched", "number of instances in contact with the closed hand",
    o.instances_touched);
  v("instances_lifted", "number of instances in the hand after hold, shake and carry",
    o.instances_lifted);
  v("instances_entangled", "number of other instances that came out without contact to the hand",
    o.instances_entangled);
  v("lift_height_mm", "height of the instance that rose most, at the end of the lift",
    1e3 * o.lift_height_m);
  v("opening_mm", "final opening of the hand", 1e3 * o.final_opening_m);
  v("force_x_n", "mean force on the hand during the hold, x in frame G", o.contact_force_n.x());
  v("force_y_n", "mean force on the hand during the hold, y in frame G", o.contact_force_n.y());
  v("force_z_n", "mean force on the hand during the hold, z in frame G", o.contact_force_n.z());
  v("torque_x_nm", "mean torque on the hand about the origin of G, x in frame G",
    o.contact_torque_nm.x());
  v("torque_y_nm", "mean torque on the hand about the origin of G, y in frame G",
    o.contact_torque_nm.y());
  v("torque_z_nm", "mean torque on the hand about the origin of G, z in frame G",
    o.contact_torque_nm.z());
  v("retention_g",
    "load at which the hold test lost the instance, or its limit, multiples of g; empty if not "
    "measured",
    o.retention_g);
  v("drop_time_s",
    "time from the end of the lift until the instance was lost; empty if it was not, or not "
    "measured",
    o.drop_time_s);
  v("place_error_mm", "distance of the center of mass from its planned place; empty if not placed",
    1e3 * o.place_error_m);
  v("place_rotation_error_deg",
    "rotation error at the place, minimum over the symmetries; empty if not placed",
    kDegreesPerRadian * o.place_rotation_error_rad);
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

ResultColumns OutcomeColumns() {
  ResultColumns columns;
  VisitCells({}, [&](const char* name, const std::string& help, auto) {
    columns.push_back({name, help});
  });
  return columns;
}

std::string OutcomeCells(const AttemptRecord& attempt) {
  std::string cells;
  const GraspOutcome& outcome = attempt.outcome;
  const auto is_measured = [&](std::string_view name) {
    if (name.starts_with("place_")) return outcome.place_executed;
    if (name == "retention_g") return outcome.retention_g >= 0;
    return name != "drop_time_s" || outcome.drop_time_s >= 0;
  };
  VisitCells(outcome, [&](std::string_view name, const std::string&, auto value) {
    const bool is_known = attempt.grasp && is_measured(name);
    cells += is_known ? fmt::format(",{}", value) : ",";
  });
  return cells;
}

}  // namespace pickbed::eval
