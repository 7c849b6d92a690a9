#include "scenes/scenario/failure_reason.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(FailureTable, RowsAreInEnumOrderWithUniqueNames) {
  std::set<std::string_view> names;
  for (size_t i = 0; i < FailureTable().size(); ++i) {
    const FailureRow& row = FailureTable()[i];
    EXPECT_EQ(static_cast<size_t>(row.failure), i);
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(FailureFromName(FailureName(row.failure)), row.failure);
    EXPECT_EQ(StageOf(row.failure) == Stage::kDone, row.failure == FailureReason::kNone);
    EXPECT_FALSE(StageName(row.stage).empty());
  }
  EXPECT_EQ(FailureTable().size(), kFailureReasons);
  EXPECT_FALSE(FailureFromName("no such loss"));
}

}  // namespace
}  // namespace pickbed::tests
