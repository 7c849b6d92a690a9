#include "grasp/outcome.h"

#include "grasp/grasp.h"
#include "scenes/base/error.h"

namespace pickbed::grasp {
namespace {

bool Contact(const GraspOutcome& o, const RuleOptions&) { return o.instances_touched > 0; }

bool Lifted(const GraspOutcome& o, const RuleOptions&) { return o.instances_risen > 0; }

bool Held(const GraspOutcome& o, const RuleOptions&) { return o.instances_lifted > 0; }

bool RightInstance(const GraspOutcome& o, const RuleOptions&) {
  return o.instances_lifted == 1 && o.is_target;
}

bool SingleInstance(const GraspOutcome& o, const RuleOptions&) { return o.instances_lifted == 1; }

bool Placed(const GraspOutcome& o, const RuleOptions& options) {
  return RightInstance(o, options) && o.place_executed &&
         o.place_error_m <= options.place_tolerance_m &&
         o.place_rotation_error_rad <= options.place_tolerance_rad;
}

bool VgnLoose(const GraspOutcome& o, const RuleOptions& options) {
  return o.retreat_contact && o.retreat_opening > options.loose_opening;
}

}  // namespace

void RuleOptions::Visit(SettingsVisitor& v) {
  v.Real("place_tolerance_m", place_tolerance_m, {0, 1}, "of the centre of mass, for placed, m");
  v.Real("place_tolerance_rad", place_tolerance_rad, {0, 3.2}, "of the orientation, rad");
  v.Real("loose_opening", loose_opening, {0, 1}, "share of the stroke, for vgn_loose");
}

std::span<const SuccessRuleRow> SuccessRuleTable() {
  static constexpr std::array<SuccessRuleRow, kSuccessRules> kTable{{
      {SuccessRule::kContact, "contact", "the closed hand touched a part", Contact, false},
      {SuccessRule::kLifted, "lifted", "a part hung in the hand at the end of the lift", Lifted,
       false},
      {SuccessRule::kHeld, "held", "a part stayed in the hand: hold, shake, carried out", Held,
       false},
      {SuccessRule::kRightInstance, "right_instance", "held, the part that was meant and no other",
       RightInstance, true},
      {SuccessRule::kSingleInstance, "single_instance", "held, exactly one part, whichever",
       SingleInstance, false},
      {SuccessRule::kPlaced, "placed", "the right part lies where it was to be set down", Placed,
       true},
      {SuccessRule::kVgnLoose, "vgn_loose",
       "any contact and fingers over 10 % open after 10 cm of retreat (VGN)", VgnLoose, false},
  }};
  return kTable;
}

SuccessRule SuccessRuleNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    if (name == row.name) return row.rule;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("success rule", name, names));
}

SuccessRule DecidingRule(const std::string& name) {
  const SuccessRule rule = SuccessRuleNamed(name);
  std::string others;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    if (!row.decides) continue;
    if (row.rule == rule) return rule;
    others += (others.empty() ? "" : " or ") + std::string(row.name);
  }
  throw InputError("'" + name + "' is judged beside the others, but a part that stays or another " +
                   "that comes passes it, so it cannot decide a pick; choose " + others);
}

SuccessVerdicts JudgeByAllRules(const GraspOutcome& outcome, const RuleOptions& options) {
  CheckSettings("RuleOptions", options);
  SuccessVerdicts verdicts{};
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    verdicts[static_cast<int>(row.rule)] = row.judge(outcome, options);
  }
  return verdicts;
}

}  // namespace pickbed::grasp
