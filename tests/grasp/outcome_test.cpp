#include "grasp/outcome.h"

#include <gtest/gtest.h>

#include "grasp/grasp.h"
#include "scenes/base/error.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Returns the outcome of a grasp that passes every rule.
GraspOutcome Successful() {
  GraspOutcome outcome;
  outcome.instances_touched = outcome.instances_risen = outcome.instances_lifted = 1;
  outcome.is_target = true;
  outcome.retreat_contact = true;
  outcome.retreat_opening = 0.5;
  outcome.place_executed = true;
  return outcome;
}

// Returns the names of the passed rules.
std::string Passed(const GraspOutcome& outcome, const RuleOptions& options = {}) {
  const SuccessVerdicts verdicts = JudgeByAllRules(outcome, options);
  std::string names;
  for (const SuccessRuleRow& row : SuccessRuleTable()) {
    if (verdicts[static_cast<int>(row.rule)]) names += std::string(row.name) + " ";
  }
  return names;
}

TEST(SuccessRules, TableIsInEnumOrderWithHelp) {
  ASSERT_EQ(SuccessRuleTable().size(), static_cast<size_t>(kSuccessRules));
  for (int i = 0; i < kSuccessRules; ++i) {
    const SuccessRuleRow& row = SuccessRuleTable()[i];
    EXPECT_EQ(static_cast<int>(row.rule), i);
    EXPECT_EQ(SuccessRuleNamed(row.name), row.rule);
    EXPECT_GT(std::string(row.help).size(), 10u);
  }
}

TEST(SuccessRules, UnknownRuleErrorListsTheKnownRules) {
  try {
    SuccessRuleNamed("right-part");
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    const std::string line = error.what();
    EXPECT_NE(line.find("unknown success rule 'right-part'"), std::string::npos) << line;
    EXPECT_NE(line.find("right_instance"), std::string::npos) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
  }
}

TEST(SuccessRules, SuccessfulGraspPassesAllAndEmptyOutcomeNone) {
  EXPECT_EQ(Passed(Successful()),
            "contact lifted held right_instance single_instance placed vgn_loose ");
  EXPECT_EQ(Passed(GraspOutcome()), "");
}

struct RuleCase {
  const char* what;
  void (*change)(GraspOutcome&);
  const char* passed;
};
void PrintTo(const RuleCase& rule_case, std::ostream* out) { *out << rule_case.what; }
class ChangedOutcome : public testing::TestWithParam<RuleCase> {};

TEST_P(ChangedOutcome, PassesOnlyTheRulesThatIgnoreTheChange) {
  GraspOutcome outcome = Successful();
  GetParam().change(outcome);
  EXPECT_EQ(Passed(outcome), GetParam().passed) << GetParam().what;
}

INSTANTIATE_TEST_SUITE_P(
    Facts, ChangedOutcome,
    testing::Values(
        RuleCase{"two instances came out", [](GraspOutcome& o) { o.instances_lifted = 2; },
                 "contact lifted held vgn_loose "},
        RuleCase{"another instance came out", [](GraspOutcome& o) { o.is_target = false; },
                 "contact lifted held single_instance vgn_loose "},
        RuleCase{"lost while it was held", [](GraspOutcome& o) { o.instances_lifted = 0; },
                 "contact lifted vgn_loose "},
        RuleCase{"slipped on the way up",
                 [](GraspOutcome& o) {
                   o.instances_risen = o.instances_lifted = 0;
                   o.retreat_contact = false;
                 },
                 "contact "},
        RuleCase{"fingers nearly met", [](GraspOutcome& o) { o.retreat_opening = 0.09; },
                 "contact lifted held right_instance single_instance placed "},
        RuleCase{"set down 11 mm off", [](GraspOutcome& o) { o.place_error_m = 0.011; },
                 "contact lifted held right_instance single_instance vgn_loose "},
        RuleCase{"set down turned by 11 degrees",
                 [](GraspOutcome& o) { o.place_rotation_error_rad = 0.19; },
                 "contact lifted held right_instance single_instance vgn_loose "},
        RuleCase{"not set down", [](GraspOutcome& o) { o.place_executed = false; },
                 "contact lifted held right_instance single_instance vgn_loose "}));

TEST(SuccessRules, TolerancesAreOptions) {
  GraspOutcome outcome = Successful();
  outcome.place_error_m = 0.011;
  RuleOptions options;
  options.place_tolerance_m = 0.012;
  options.loose_opening = 0.6;
  EXPECT_EQ(Passed(outcome, options), "contact lifted held right_instance single_instance placed ");
}

}  // namespace
}  // namespace pickbed::tests
