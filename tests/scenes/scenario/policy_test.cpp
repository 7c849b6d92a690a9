#include "scenes/scenario/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

TEST(Policy, PoliciesEndAtTheirDocumentedState) {
  PolicySpec policy;
  policy.max_failures_in_row = 3;
  const PolicyState progressing{10, 2, true}, failing{10, 3, true}, nothing_found{10, 1, false};
  const struct {
    const char* name;
    bool progressing, failing, nothing_found;
    int max_attempts;
  } cases[] = {{"until_empty", false, true, true, 0},
               {"capture_again", false, true, false, 0},
               {"one_pick", false, false, false, 1}};
  ASSERT_EQ(PolicyTable().size(), std::size(cases));
  for (const auto& c : cases) {
    const PolicyRow& row = PolicyNamed(c.name);
    EXPECT_EQ(row.gives_up(progressing, policy), c.progressing) << c.name;
    EXPECT_EQ(row.gives_up(failing, policy), c.failing) << c.name;
    EXPECT_EQ(row.gives_up(nothing_found, policy), c.nothing_found) << c.name;
    EXPECT_EQ(row.max_attempts, c.max_attempts) << c.name;
  }
}

TEST(Policy, UnknownPolicyErrorListsTheKnownPolicies) {
  const std::string direct = ErrorOf([] { PolicyNamed("until_emtpy"); });
  EXPECT_THAT(direct, HasSubstr("did you mean 'until_empty'? known: until_empty, capture_again"));
  PolicySpec policy;
  const std::string setting =
      ErrorOf([&] { ApplySetting("stop=never", [&](SettingsVisitor& v) { policy.Visit(v); }); });
  EXPECT_THAT(setting,
              HasSubstr("unknown stop 'never'; known: until_empty, capture_again, one_pick"));
}

}  // namespace
}  // namespace pickbed::tests
