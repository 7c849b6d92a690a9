#pragma once

// Success rules of a grasp. All rules are evaluated on the facts of the same executed grasp, so
// that results can be compared with published ones.
//
// Each rule is one row of the table in outcome.cpp. The loose rule is from Breyer et al. 2020
// ("Volumetric Grasping Network", clutter removal). It requires any contact, and fingers more than
// 10 % open, after the hand has retreated by 10 cm. It does not check which instance was picked or
// whether it stays in the hand.

#include <array>
#include <span>
#include <string>

#include "grasp/layer.h"
#include "scenes/base/settings.h"

namespace pickbed::grasp {

enum class SuccessRule {
  kContact,         // the closed hand touched an instance
  kLifted,          // an instance was in the hand at the end of the lift
  kHeld,            // an instance was still in the hand after hold, shake and carry
  kRightInstance,   // like kHeld, and only the target was in the hand
  kSingleInstance,  // like kHeld, and exactly one instance was in the hand
  kPlaced,          // only the target was picked, and it was set down at the planned pose
  kVgnLoose,        // rule of Breyer et al., see above
};
inline constexpr int kSuccessRules = 7;

// One verdict per rule; the index is static_cast<int>(rule).
using SuccessVerdicts = std::array<bool, kSuccessRules>;

// Thresholds of the success rules.
struct RuleOptions {
  double place_tolerance_m = 0.01;     // of the center of mass, for "placed"
  double place_tolerance_rad = 0.175;  // minimum over the symmetries, for "placed"
  double loose_opening = 0.1;          // minimum share of the stroke, for "vgn_loose"
  void Visit(SettingsVisitor& v);
};

struct GraspOutcome;  // grasp/grasp.h

// Success rule with its name and function.
struct SuccessRuleRow {
  SuccessRule rule;
  const char* name;  // stable key in JSON, CSV and the results store
  const char* help;
  bool (*judge)(const GraspOutcome& outcome, const RuleOptions& options);
  // True if the rule passes only when exactly the target left the bin. Only such a rule can decide
  // a pick: picking then ends, and no instance is counted twice.
  bool decides;
};

// All rules, in the order of SuccessRule.
std::span<const SuccessRuleRow> SuccessRuleTable();

// Returns the rule with this name. Throws InputError that lists the known names.
SuccessRule SuccessRuleNamed(const std::string& name);

// Returns the rule with this name, which must be able to decide a pick (`decides`). Throws
// InputError for an unknown name or for a rule that cannot decide.
SuccessRule DecidingRule(const std::string& name);

// Evaluates every rule on the facts of `outcome`. It does not read `outcome.verdicts`.
SuccessVerdicts JudgeByAllRules(const GraspOutcome& outcome, const RuleOptions& options = {});

}  // namespace pickbed::grasp
