#include "eval/budget/charts.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

Waterfall TwoFailures() {
  return {"title", "all attempts",
          "all",   {"picked", "", 26, {0.5, 0.8}},
          40,      {{"pose_wrong", "pose", 4, {0.05, 0.2}}, {"slipped", "grasp", 10, {0.2, 0.4}}}};
}

TEST(WaterfallChart, EachBarBeginsAtTheEndOfTheBarAbove) {
  const auto spec = nlohmann::json::parse(WaterfallChart("id", TwoFailures()).spec);
  const auto& bars = spec["data"]["values"];
  ASSERT_EQ(bars.size(), 4u);
  EXPECT_EQ(bars[0]["to"], 1);
  double end = 1;
  for (size_t i = 1; i + 1 < bars.size(); ++i) {
    EXPECT_DOUBLE_EQ(bars[i]["to"], end);
    end = bars[i]["from"];
  }
  EXPECT_DOUBLE_EQ(bars.back()["to"], end) << "the remaining attempts are the successful ones";
  EXPECT_DOUBLE_EQ(end, 26.0 / 40);
}

TEST(WaterfallChart, TooFewBinsLeaveOutTheLines) {
  Waterfall waterfall = TwoFailures();
  waterfall.left.ci95 = Interval::Unknown();
  for (WaterfallStep& step : waterfall.steps) step.ci95 = Interval::Unknown();
  const ReportChart chart = WaterfallChart("id", waterfall);
  const auto spec = nlohmann::json::parse(chart.spec);
  for (const auto& bar : spec["data"]["values"]) EXPECT_EQ(bar["low"], bar["high"]);
  EXPECT_NE(chart.caption.find("too few bins for an interval"), std::string::npos);
  EXPECT_EQ(chart.table.back().back(), "65.0 % (too few bins)");
}

// A bar from 1 with a share of [0.05, 0.2] leaves [0.8, 0.95].
TEST(WaterfallChart, IntervalsAreAtTheEndOfTheirBar) {
  const auto spec = nlohmann::json::parse(WaterfallChart("id", TwoFailures()).spec);
  const auto& bars = spec["data"]["values"];
  EXPECT_DOUBLE_EQ(bars[1]["low"], 0.8);
  EXPECT_DOUBLE_EQ(bars[1]["high"], 0.95);
  EXPECT_DOUBLE_EQ(bars[3]["low"], 0.5);
}

TEST(WaterfallChart, EveryBarHasItsNumberAndShareBehindTheAxis) {
  const auto spec = nlohmann::json::parse(WaterfallChart("id", TwoFailures()).spec);
  const auto& bars = spec["data"]["values"];
  EXPECT_EQ(bars[0]["text"], "40");
  EXPECT_EQ(bars[1]["text"], "4 (10.0 %)");
  EXPECT_EQ(bars.back()["text"], "26 (65.0 %)");
  for (const auto& bar : bars) EXPECT_GT(bar["at"], 1) << "the text would cover a bar";
}

TEST(WaterfallChart, NoAttemptsGiveNoInfiniteShares) {
  const ReportChart chart =
      WaterfallChart("id", {"title", "all attempts", "all", {"picked", "", 0, {}}, 0, {}});
  const auto spec = nlohmann::json::parse(chart.spec);
  EXPECT_EQ(spec["data"]["values"].back()["to"], 0);
  EXPECT_EQ(chart.table.back()[3], "-");
}

TEST(GainsChart, EveryRowHasBothSeriesInPoints) {
  const GainRows gains{"title", "x", "y", {{"a", {0.5, 0.6, {0.05, 0.2}}, {0.2, 0.1, {-0.3, 0}}}}};
  const ReportChart chart = GainsChart("id", gains);
  const auto spec = nlohmann::json::parse(chart.spec);
  const auto& values = spec["data"]["values"];
  ASSERT_EQ(values.size(), 2u);
  EXPECT_NEAR(values[0]["gain"], 10, 1e-9);
  EXPECT_NEAR(values[0]["high"], 20, 1e-9);
  EXPECT_NEAR(values[1]["gain"], -10, 1e-9);
  EXPECT_EQ(chart.table[1][1], "+10.0 [+5.0, +20.0]");
}

}  // namespace
}  // namespace pickbed::tests
