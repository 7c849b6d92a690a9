#include "eval/execution/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/execution/pick_rows.h"
#include "eval/execution/report.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// One pick with an error in mm. A negative error: no grasp.
ExecutedPick Pick(const std::string& method, int scene, int pick, double error_mm) {
  ExecutedPick row;
  row.method = method;
  row.scene_id = scene;
  row.pick = pick;
  row.failure = FailureReason::kNoGrasp;
  if (error_mm < 0) return row;
  row.object_id = 1;
  row.score = -error_mm;
  row.instance = InstanceId(3);
  row.visible_fraction = 0.5;
  row.errors = {0.1, 1e-3 * error_mm, 2, 1e-3 * error_mm, 5e-4 * error_mm};
  row.success = error_mm < 4;
  row.failure = row.success ? FailureReason::kNone : FailureReason::kPoseWrong;
  return row;
}

// Method a: one success and one pick without a grasp per scene. Method b: one success, one failure.
std::vector<ExecutedPick> Picks(int scenes) {
  std::vector<ExecutedPick> picks;
  for (int scene = 1; scene <= scenes; ++scene) {
    picks.push_back(Pick("a", scene, 0, 1));
    picks.push_back(Pick("a", scene, 1, -1));
    picks.push_back(Pick("b", scene, 0, 2));
    picks.push_back(Pick("b", scene, 1, 5 + scene));
  }
  return picks;
}

TEST(PickRows, PassThroughTheFile) {
  std::string text;
  for (const ExecutedPick& pick : Picks(2)) text += PickRow(pick);
  const std::vector<ExecutedPick> read = ReadPickRows(text + "b,2,0,1,1,-7");
  ASSERT_EQ(read.size(), 8u) << "the cut-off line is ignored";
  std::string again;
  for (const ExecutedPick& pick : read) again += PickRow(pick);
  EXPECT_EQ(again, text);
  EXPECT_EQ(ReadPickRows("b,2,0,1,1,x,3,0.5,0.1,0.1,2,0.1,0.1,1,none\n").size(), 0u);
  ExecutedPick stranger = Pick("a", 1, 0, 1);
  stranger.errors.mssd_m = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ReadPickRows(PickRow(stranger)).front().errors.mssd_m, stranger.errors.mssd_m);
}

TEST(ExecutionStatistics, EqualHandCountedValues) {
  const ExecutionStatistics statistics = StatisticsOf({"a", "b"}, Picks(6));
  EXPECT_EQ(statistics.scenes, 6);
  EXPECT_EQ(statistics.picks, 24);
  const MethodStatistics &a = statistics.methods[0], &b = statistics.methods[1];
  EXPECT_EQ(a.requested.samples, 12);
  EXPECT_EQ(a.requested.hits, 6);
  EXPECT_EQ(a.executed.samples, 6) << "a pick without a grasp is not executed";
  EXPECT_EQ(a.executed.hits, 6);
  EXPECT_EQ(a.failures.at(FailureReason::kNoGrasp).hits, 6);
  EXPECT_EQ(b.failures.at(FailureReason::kPoseWrong).hits, 6);
  EXPECT_DOUBLE_EQ(b.by_pick[0].rate(), 1);
  EXPECT_DOUBLE_EQ(b.by_pick[1].rate(), 0);
  // MSSD separates the picks of b; VSD is the same for all of them.
  EXPECT_DOUBLE_EQ(b.predictors[1].auc.auc, 1);
  EXPECT_DOUBLE_EQ(b.predictors[0].auc.auc, 0.5);
  EXPECT_FALSE(a.predictors[1].auc.is_known()) << "all executed picks of a succeed";
  ASSERT_EQ(statistics.paired.size(), 1u);
  const std::vector<PairedStatistic>& paired = statistics.paired[0].paired.statistics;
  EXPECT_DOUBLE_EQ(paired[0].difference(), 0);
  EXPECT_DOUBLE_EQ(paired[1].difference(), -0.5);
  EXPECT_LT(paired[1].p_value, 0.05);
}

TEST(ExecutionReport, ShowsEveryMethod) {
  const ExecutionStatistics statistics = StatisticsOf({"a", "b"}, Picks(6));
  const std::string text = ExecutionText(statistics);
  EXPECT_THAT(text, HasSubstr("100.0 %"));
  EXPECT_THAT(text, HasSubstr("pose_wrong"));
  EXPECT_THAT(text, HasSubstr("A is a, B is b"));
  const auto json = nlohmann::json::parse(ExecutionJson(statistics));
  EXPECT_EQ(json["methods"][1]["failures"]["pose_wrong"]["picks"], 6);
  EXPECT_EQ(json["methods"][1]["predictors"]["mssd"]["auc"], 1);
  EXPECT_TRUE(json["methods"][0]["predictors"]["mssd"]["auc"].is_null());
  const std::string page = ExecutionPage(statistics, "Data set x, gripper y").body();
  for (const char* shown : {"Data set x", "success", "by-pick", "auc", "Paired differences"}) {
    EXPECT_THAT(page, HasSubstr(shown));
  }
}

}  // namespace
}  // namespace pickbed::tests
