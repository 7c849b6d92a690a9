#include "scenes/loss.h"

#include <gtest/gtest.h>

#include <set>

namespace pickbed {
namespace {

TEST(LossTable, RowsStandAtTheirEnumValueWithNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (size_t i = 0; i < LossTable().size(); ++i) {
    const LossRow& row = LossTable()[i];
    EXPECT_EQ(static_cast<size_t>(row.loss), i);
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(LossFromName(LossName(row.loss)), row.loss);
    EXPECT_EQ(StageOf(row.loss) == Stage::kDone, row.loss == Loss::kNone);
    EXPECT_FALSE(StageName(row.stage).empty());
  }
  EXPECT_EQ(LossTable().size(), static_cast<size_t>(Loss::kPhysicsFailed) + 1);
  EXPECT_FALSE(LossFromName("no such loss"));
}

}  // namespace
}  // namespace pickbed
