#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/report/page_parts.h"
#include "tests/support/stub_trials.h"

namespace pickbed {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<PointReport> Reports(const std::vector<std::string>& names) {
  std::vector<PointTrials> points;
  for (size_t i = 0; i < names.size(); ++i) {
    points.push_back({names[i], {"rod", "flange"}, StubTrials(15, {.ease = 0.1 * i}), {}});
  }
  return ReportOn(points);
}

std::vector<ReportChart> AllCharts(const std::vector<PointReport>& points) {
  std::vector<ReportChart> charts{LossChart(points), CalibrationChart(points), SecondsChart(points),
                                  SuccessChart(points)};
  for (const ReportChart& chart : VisibilityCharts(points)) charts.push_back(chart);
  for (const ReportChart& chart : ErrorCharts(points)) charts.push_back(chart);
  return charts;
}

// Texts and numbers of a table's column.
std::vector<std::string> Column(const TableCells& cells, size_t column) {
  std::vector<std::string> values;
  for (size_t i = 1; i < cells.size(); ++i) values.push_back(cells[i].at(column));
  return values;
}

// The share of targets that were picked is drawn where looks have a target, and only there.
TEST(VisibilityCharts, DrawPickedTargetsWhereThereAreTargets) {
  PointTrials point{"one", {"rod", "flange"}, StubTrials(15, {}), {}};
  EXPECT_EQ(VisibilityCharts(ReportOn({&point, 1})).size(), 1u);
  for (TrialResult& trial : point.trials) {
    for (PickRecord& look : trial.picks) {
      if (!look.instances.empty()) look.target = look.instances.front().instance;
    }
  }
  const auto charts = VisibilityCharts(ReportOn({&point, 1}));
  ASSERT_EQ(charts.size(), 2u);
  EXPECT_EQ(charts[1].id, "target-picked");
}

// Settings of other bands stand on one axis, each where it has numbers.
TEST(VisibilityCharts, HaveTheBandsOfAllSettingsInOrder) {
  std::vector<PointTrials> points{{"a", {"rod", "flange"}, StubTrials(15), {}},
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

TEST(ErrorCharts, SayTheMedianWithItsInterval) {
  const std::vector<PointReport> points = Reports({"one"});
  const ReportChart chart = ErrorCharts(points).front();
  EXPECT_THAT(chart.caption, HasSubstr(MedianText(points[0].errors[0].median, 4) + " diameters"));
  EXPECT_THAT(chart.caption, HasSubstr("95 % intervals, with scenes as units"));
}

// Of curves over these names, at one half each.
std::string SpecOver(const std::vector<std::string>& names) {
  const std::vector<ReportRate> halves(names.size(), {1, 2, {0.1, 0.9}});
  return RateCurves({"id", "title", "caption", ""}, "x", "y", names, {{"one", halves}}).spec;
}

TEST(RateCurves, SlantNamesThatDoNotFitBesideEachOther) {
  EXPECT_THAT(SpecOver({"10-30", "30-50", "50-70"}), HasSubstr("\"labelAngle\":0"));
  const std::string many =
      SpecOver({"background", "occluded_10", "occluded_20", "occluded_30", "occluded_50"});
  EXPECT_THAT(many, HasSubstr("\"labelAngle\":-40"));
  EXPECT_THAT(many, HasSubstr("\"labelOverlap\":false"));
}

TEST(ReportPage, Base64IsThatOfRfc4648) {
  EXPECT_EQ(Base64(""), "");
  EXPECT_EQ(Base64("f"), "Zg==");
  EXPECT_EQ(Base64("fo"), "Zm8=");
  EXPECT_EQ(Base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(Base64("\xff\xfe\xfd"), "//79");
}

TEST(ReportPage, EveryChartHasDataOfEveryPointAndATable) {
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

TEST(ReportPage, TheLossChartSumsToAllLooks) {
  const std::vector<PointReport> points = Reports({"one"});
  const ReportChart chart = LossChart(points);
  const LossBudget& budget = points[0].attempts.budget;
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

TEST(ReportPage, WhereNothingWasLostOrTriedTheChartsSaySo) {
  const std::vector<PointReport> points = ReportOn(std::vector<PointTrials>{{"none", {}, {}, {}}});
  for (const ReportChart& chart : AllCharts(points)) {
    EXPECT_EQ(chart.spec, "") << chart.id;
    EXPECT_THAT(chart.caption, testing::ContainsRegex("[Nn]o|nothing")) << chart.id;
  }
}

TEST(ReportPage, ANumberBreaksBeforeItsIntervalAlone) {
  const std::string html = TableHtml({{"part", "right"}, {"rod", "87.5 % [69.0, 95.7]"}});
  EXPECT_THAT(html, HasSubstr(">87.5&nbsp;% <span>[69.0, 95.7]</span></td>"));
}

TEST(ReportPage, NamesCannotBreakThePage) {
  const std::string name = "</script><!--<script>\"'&";
  std::string html = TableHtml({{name}, {name}});
  for (const ReportChart& chart : AllCharts(Reports({name, "other"}))) html += ChartHtml(chart);
  EXPECT_THAT(html, Not(HasSubstr("<!--")));
  EXPECT_THAT(html, Not(HasSubstr("</script><")));
  EXPECT_THAT(html, HasSubstr("&lt;/script&gt;"));
}

}  // namespace
}  // namespace pickbed
