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
  v.Real("place_tolerance_m", place_tolerance_m, {0, 1},
         "maximum distance of the center of mass from its planned position for placed, m");
  v.Real("place_tolerance_rad", place_tolerance_rad, {0, 3.2},
         "maximum rotation from the planned orientation for placed, rad");
  v.Real("loose_opening", loose_opening, {0, 1},
         "minimum share of the stroke that stays open for vgn_loose");
}

std::span<const SuccessRuleRow> SuccessRuleTable() {
  static constexpr std::array<SuccessRuleRow, kSuccessRules> kTable{{
      {SuccessRule::kContact, "contact", "the closed hand touched an instance", Contact, false},
      {SuccessRule::kLifted, "lifted", "an instance was in the hand at the end of the lift", Lifted,
       false},
      {SuccessRule::kHeld, "held", "an instance was still in the hand after hold, shake and carry",
       Held, false},
      {SuccessRule::kRightInstance, "right_instance",
       "like held, and only the target was in the hand", RightInstance, true},
      {SuccessRule::kSingleInstance, "single_instance",
       "like held, and exactly one instance was in the hand", SingleInstance, false},
      {SuccessRule::kPlaced, "placed", "the target was set down at its planned pose", Placed, true},
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
  throw InputError("'" + name + "' does not require that exactly the target leaves the bin, " +
                   "so it cannot decide a pick; choose " + others);
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
