#pragma once

// What counts as a successful grasp. Rules are judged from the facts of one executed grasp, all of
// them side by side, so that figures can be compared with those of others.
//
// A rule is one row in success_rules.cpp. The loose one is that of Breyer et al. 2020 ("Volumetric
// Grasping Network", clutter removal): any contact, and fingers more than a tenth open, after the
// hand has drawn back by 10 cm; which part came, and whether it stays, is not asked.

#include <array>
#include <span>
#include <string>

#include "scenes/settings.h"

namespace pickbed {

enum class SuccessRule {
  kContact,     // the closed hand touched a part
  kLifted,      // a part hung in the hand at the end of the lift
  kHeld,        // a part was still in it after hold, shake and carry
  kRightPart,   // the part that was meant was, and no other
  kSinglePart,  // exactly one part was, whichever
  kPlaced,      // the part that was meant, alone, lies where it was to be set down
  kVgnLoose,    // see above
};
inline constexpr int kSuccessRules = 7;

// By rule: verdicts[static_cast<int>(rule)].
using SuccessVerdicts = std::array<bool, kSuccessRules>;

struct RuleOptions {
  double place_tolerance_m = 0.01;     // of the centre of mass, for "placed"
  double place_tolerance_rad = 0.175;  // of the orientation, least over the part's symmetries
  double loose_opening = 0.1;          // share of the stroke, for "vgn_loose"
  void Visit(SettingsVisitor& v);
};

struct GraspOutcome;  // grasp/grasp.h

struct SuccessRuleRow {
  SuccessRule rule;
  const char* name;  // stable key in JSON, CSV and the store
  const char* help;
  bool (*judge)(const GraspOutcome& outcome, const RuleOptions& options);
  // Whether only the part that was meant, alone and out of the bin, passes: picking by this rule
  // comes to an end, and no part is counted twice.
  bool decides;
};

// In the order of the enum.
std::span<const SuccessRuleRow> SuccessRuleTable();

// Throws InputError with the known names.
SuccessRule SuccessRuleNamed(const std::string& name);

// The same, for a rule that is to decide whether a pick brought its part. Throws InputError for one
// that cannot.
SuccessRule DecidingRule(const std::string& name);

// Every rule on the facts of `outcome`; its own verdicts are not read.
SuccessVerdicts JudgeByAllRules(const GraspOutcome& outcome, const RuleOptions& options = {});

}  // namespace pickbed
