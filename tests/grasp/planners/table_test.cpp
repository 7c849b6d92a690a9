#include "grasp/planners/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

TEST(PlannerTable, NamesAreUniqueAndTheFirstIsTheDefault) {
  std::set<std::string> names;
  for (const PlannerRow& row : PlannerTable()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(std::string(row.help).empty());
    EXPECT_EQ(&PlannerNamed(row.name), &row);
  }
  EXPECT_EQ(PlannerTable().front().name, PlannerSpec().name);
  EXPECT_TRUE(PlannerTable().front().needs_poses);
}

TEST(PlannerTable, UnknownNameListsTheNearest) {
  EXPECT_THAT(ErrorOf([] { PlannerNamed("cloud_antipodl"); }), HasSubstr("cloud_antipodal"));
}

}  // namespace
}  // namespace pickbed::tests
