#include "scenes/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace pickbed {
namespace {

using ::testing::HasSubstr;

TEST(Policy, RowsEndWhereTheirHelpSays) {
  PolicySpec policy;
  policy.max_failures_in_row = 3;
  const PolicyState fine{10, 2, true}, tired{10, 3, true}, blind{10, 1, false};
  const struct {
    const char* name;
    bool fine, tired, blind;
    int most_looks;
  } cases[] = {{"until_empty", false, true, true, 0},
               {"look_again", false, true, false, 0},
               {"one_pick", false, false, false, 1}};
  ASSERT_EQ(PolicyTable().size(), std::size(cases));
  for (const auto& c : cases) {
    const PolicyRow& row = PolicyNamed(c.name);
    EXPECT_EQ(row.gives_up(fine, policy), c.fine) << c.name;
    EXPECT_EQ(row.gives_up(tired, policy), c.tired) << c.name;
    EXPECT_EQ(row.gives_up(blind, policy), c.blind) << c.name;
    EXPECT_EQ(row.most_looks, c.most_looks) << c.name;
  }
}

TEST(Policy, AnUnknownOneIsToldWithTheKnown) {
  const std::string direct = ErrorOf([] { PolicyNamed("until_emtpy"); });
  EXPECT_THAT(direct, HasSubstr("did you mean 'until_empty'? known: until_empty, look_again"));
  PolicySpec policy;
  const std::string setting =
      ErrorOf([&] { ApplySetting("stop=never", [&](SettingsVisitor& v) { policy.Visit(v); }); });
  EXPECT_THAT(setting, HasSubstr("unknown stop 'never'; known: until_empty, look_again, one_pick"));
}

}  // namespace
}  // namespace pickbed
