#include "eval/report/run_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/page/html.h"
#include "tests/support/stub_trials.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<ConfigurationReport> Reports(const std::vector<std::string>& names) {
  std::vector<ConfigurationTrials> points;
  for (size_t i = 0; i < names.size(); ++i) {
    points.push_back({names[i], {"rod", "flange"}, StubTrials(15, {.ease = 0.1 * i}), {}});
    points.back().trials[0].attempts[0].grasps_rejected = {{"tilt", 30}, {"quality", 10}};
  }
  return ReportOn(points);
}

std::vector<ReportChart> AllCharts(const std::vector<ConfigurationReport>& points) {
  std::vector<ReportChart> charts{FailureChart(points), CalibrationChart(points),
                                  SecondsChart(points), SuccessChart(points)};
  for (const ReportChart& chart : VisibilityCharts(points)) charts.push_back(chart);
  for (const ReportChart& chart : ErrorCharts(points)) charts.push_back(chart);
  for (const ReportChart& chart : ErrorByBandCharts(points)) charts.push_back(chart);
  charts.push_back(AttemptsChart(points));
  charts.push_back(FillChart(points));
  charts.push_back(RejectionsChart(points));
  return charts;
}

// Cells of a table column without its header.
std::vector<std::string> Column(const TableCells& cells, size_t column) {
  std::vector<std::string> values;
  for (size_t i = 1; i < cells.size(); ++i) values.push_back(cells[i].at(column));
  return values;
}

// A forecast is a mark of its own and a column of the table, only where there is one.
TEST(SuccessChart, ShowsTheForecastOfTheToleranceMaps) {
  std::vector<ConfigurationReport> points = Reports({"a", "b"});
  EXPECT_THAT(SuccessChart(points).spec, Not(HasSubstr("diamond")));
  PickForecast forecast;
  forecast.picks = 8;
  forecast.expected_with_grasp = 6;
  points[1].summary.forecasts = {forecast};
  const ReportChart chart = SuccessChart(points);
  EXPECT_EQ(chart.table[0].back(), "forecast");
  EXPECT_EQ(chart.table[1].back(), "");
  EXPECT_EQ(chart.table[2].back(), PercentText(0.75));
  const auto spec = nlohmann::json::parse(chart.spec);
  EXPECT_FALSE(spec["data"]["values"][0].contains("forecast"));
  EXPECT_EQ(spec["data"]["values"][1]["forecast"], 0.75);
  EXPECT_EQ(spec["layer"].back()["mark"]["shape"], "diamond");
}

// The share of picked targets is drawn only if attempts have a target.
TEST(VisibilityCharts, DrawPickedTargetsOnlyIfThereAreTargets) {
  ConfigurationTrials point{"one", {"rod", "flange"}, StubTrials(15, {}), {}};
  EXPECT_EQ(VisibilityCharts(ReportOn({&point, 1})).size(), 1u);
  for (TrialResult& trial : point.trials) {
    for (AttemptRecord& attempt : trial.attempts) {
      if (!attempt.instances.empty()) attempt.target = attempt.instances.front().instance;
    }
  }
  const auto charts = VisibilityCharts(ReportOn({&point, 1}));
  ASSERT_EQ(charts.size(), 2u);
  EXPECT_EQ(charts[1].id, "target-picked");
}

// Configurations with different bands share one axis. Each is drawn only where it has values.
TEST(VisibilityCharts, HaveTheBandsOfAllConfigurationsInOrder) {
  std::vector<ConfigurationTrials> points{{"a", {"rod", "flange"}, StubTrials(15), {}},
                                          {"b", {"rod", "flange"}, StubTrials(15), {}}};
  points[0].bands = {{0.6, 0.9}, {0.9, 1}};
  points[1].bands = {{0.25, 0.5}, {0.9, 1}};
  const ReportChart chart = VisibilityCharts(ReportOn(points)).front();
  EXPECT_THAT(Column(chart.table, 0), testing::ElementsAre("25-50", "60-90", "90-100"));
  EXPECT_EQ(chart.table[1][1], "-");
  EXPECT_NE(chart.table[1][3], "-");
  EXPECT_NE(chart.table[2][1], "-");
  EXPECT_EQ(chart.table[2][3], "-");
  const auto spec = nlohmann::json::parse(chart.spec);
  EXPECT_EQ(spec["layer"][0]["encoding"]["x"]["scale"]["domain"].size(), 3u);
}

TEST(ErrorCharts, CaptionHasTheMedianWithItsInterval) {
  const std::vector<ConfigurationReport> points = Reports({"one"});
  const ReportChart chart = ErrorCharts(points).front();
  EXPECT_THAT(chart.caption, HasSubstr(MedianText(points[0].errors[0].median, 4) + " diameters"));
  EXPECT_THAT(chart.caption, HasSubstr("95 % intervals over bins"));
}

TEST(RunPage, EveryChartHasATableAndDataOfEveryConfiguration) {
  for (const std::vector<std::string>& names : {std::vector<std::string>{"one"},
                                                {"ppf", "descriptor"},
                                                {"a", "b", "c", "d", "e", "f", "g", "h", "i"}}) {
    for (const ReportChart& chart : AllCharts(Reports(names))) {
      SCOPED_TRACE(chart.id);
      const auto spec = nlohmann::json::parse(chart.spec);
      EXPECT_EQ(spec.at("$schema"), "https://vega.github.io/schema/vega-lite/v5.json");
      ASSERT_FALSE(spec.at("data").at("values").empty());
      EXPECT_GT(chart.table.size(), 1u);
      for (const auto& row : chart.table) EXPECT_EQ(row.size(), chart.table[0].size());
      if (names.size() == 1) continue;
      for (const std::string& name : names) {
        bool found = false;
        for (const auto& value : spec["data"]["values"]) found |= value.at("series") == name;
        EXPECT_TRUE(found) << name;
      }
    }
  }
}

TEST(RunPage, FailureChartSumsToAllAttempts) {
  const std::vector<ConfigurationReport> points = Reports({"one"});
  const ReportChart chart = FailureChart(points);
  const FailureBudget& budget = points[0].attempts.budget;
  int sum = 0;
  for (const std::string& count : Column(chart.table, 3)) sum += std::stoi(count);
  EXPECT_EQ(sum, budget.total);
  double share = 0;
  const nlohmann::json spec = nlohmann::json::parse(chart.spec);
  for (const auto& bar : spec["data"]["values"]) {
    share += bar["share"].get<double>();
  }
  EXPECT_NEAR(share, 1 - static_cast<double>(budget.picked) / budget.total, 1e-9);
}

TEST(RejectionsChart, SharesAreOfAllRejectedAndTheMostFrequentIsFirst) {
  const TableCells table = RejectionsChart(Reports({"one"})).table;
  ASSERT_EQ(table.size(), 3u);
  EXPECT_EQ(table[1], (std::vector<std::string>{"tilt", "30", "75.0 %"}));
  EXPECT_EQ(table[2], (std::vector<std::string>{"quality", "10", "25.0 %"}));
}

TEST(RunPage, ChartsWithoutDataHaveACaptionThatSaysSo) {
  const std::vector<ConfigurationReport> points =
      ReportOn(std::vector<ConfigurationTrials>{{"none", {}, {}, {}}});
  for (const ReportChart& chart : AllCharts(points)) {
    EXPECT_EQ(chart.spec, "") << chart.id;
    EXPECT_THAT(chart.caption, testing::ContainsRegex("[Nn]o|nothing")) << chart.id;
  }
}

TEST(RunPage, NamesAreEscaped) {
  const std::string name = "</script><!--<script>\"'&";
  std::string html = TableHtml({{name}, {name}});
  for (const ReportChart& chart : AllCharts(Reports({name, "other"}))) html += ChartHtml(chart);
  EXPECT_THAT(html, Not(HasSubstr("<!--")));
  EXPECT_THAT(html, Not(HasSubstr("</script><")));
  EXPECT_THAT(html, HasSubstr("&lt;/script&gt;"));
}

}  // namespace
}  // namespace pickbed::tests
