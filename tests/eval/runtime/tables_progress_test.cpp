#include "eval/runtime/tables_progress.h"

#include <gtest/gtest.h>

namespace pickbed::eval {
namespace {

TablesProgress ThreeTables() {
  return TablesProgress(
      {{"shapes", "shape", 0, 2}, {"grasp", "trial", 10, 3}, {"bins", "bin", 4, 5}});
}

TEST(TablesProgress, ExpectsTheTablesThatHaveNotBegun) {
  TablesProgress progress = ThreeTables();
  const ProgressState state = progress.State(1, 8);
  EXPECT_EQ(state.what, "shape");
  EXPECT_EQ(state.done, 1);
  EXPECT_EQ(state.total, 8);
  EXPECT_EQ(state.note, "table shapes, 1 of 3");
  EXPECT_DOUBLE_EQ(state.later_s, 10 * 3 + 4 * 5);
}

// 8 shapes of 2 s each were expected to take 16 s. They took three times as long.
TEST(TablesProgress, LaterTablesFollowThePaceSoFar) {
  TablesProgress progress = ThreeTables();
  progress.State(8, 8);
  progress.EndTable(48);
  EXPECT_EQ(progress.State(0, 10).note, "table grasp, 2 of 3");
  EXPECT_DOUBLE_EQ(progress.State(5, 10).later_s, 3 * 4 * 5);
  progress.EndTable(1);
  EXPECT_DOUBLE_EQ(progress.State(0, 4).later_s, 0) << "nothing follows the last table";
}

// 2 instead of 10 trials and 8 shapes should take 6 and 16 s, together 22 s. They took 11 s.
TEST(TablesProgress, ThePaceIsOfTheItemsThatATableReallyHas) {
  TablesProgress progress({{"shapes", "shape", 0, 2},
                           {"grasp", "trial", 10, 3},
                           {"bins", "bin", 4, 5},
                           {"more", "bin", 1, 100}});
  progress.State(0, 8);
  progress.EndTable(5);
  progress.State(0, 2);
  progress.EndTable(6);
  EXPECT_DOUBLE_EQ(progress.State(0, 4).later_s, 0.5 * 100);
}

TEST(TablesProgress, ATableWithoutItemsKeepsThePace) {
  TablesProgress progress = ThreeTables();
  progress.State(0, 0);
  progress.EndTable(0.1);
  EXPECT_DOUBLE_EQ(progress.State(0, 10).later_s, 4 * 5);
}

}  // namespace
}  // namespace pickbed::eval
