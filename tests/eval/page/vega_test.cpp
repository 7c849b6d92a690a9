#include "eval/page/vega.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kBands{"10-30", "30-50", "50-70"};

// Spec of curves over these names, with the rate 1/2 at each name.
std::string SpecOver(const std::vector<std::string>& names) {
  const std::vector<ReportRate> halves(names.size(), {1, 2, {0.1, 0.9}});
  return RateCurves({"id", "title", "caption", ""}, "x", "y", names, {{"one", halves}}).spec;
}

// Layers with this type of mark.
std::vector<Json> LayersOf(const Json& spec, const std::string& mark) {
  std::vector<Json> layers;
  for (const Json& layer : spec["layer"]) {
    if (layer["mark"]["type"] == mark) layers.push_back(layer);
  }
  return layers;
}

TEST(RateCurves, LongNamesAreSlanted) {
  EXPECT_THAT(SpecOver(kBands), HasSubstr("\"labelAngle\":0"));
  const std::string many =
      SpecOver({"background", "occluded_10", "occluded_20", "occluded_30", "occluded_50"});
  EXPECT_THAT(many, HasSubstr("\"labelAngle\":-40"));
  EXPECT_THAT(many, HasSubstr("\"labelOverlap\":false"));
}

TEST(RateCurves, IntervalsAreDrawnAsABand) {
  const Json spec = Json::parse(SpecOver(kBands));
  const std::vector<Json> areas = LayersOf(spec, "area");
  ASSERT_EQ(areas.size(), 1u);
  EXPECT_EQ(areas[0]["encoding"]["y"]["field"], "low");
  EXPECT_EQ(areas[0]["encoding"]["y2"]["field"], "high");
  EXPECT_EQ(spec["data"]["values"][0]["low"], 0.1);
  EXPECT_EQ(spec["data"]["values"][0]["high"], 0.9);
}

TEST(RateCurves, NamesWithoutSamplesInterruptTheLineAndHaveARow) {
  const RateCurve curve{"one", {{1, 2, {0.1, 0.9}}, {}, {2, 2, {0.3, 1}}}};
  const ReportChart chart = RateCurves({"id", "title", "", ""}, "x", "y", kBands, {curve});
  const Json spec = Json::parse(chart.spec);
  ASSERT_EQ(spec["data"]["values"].size(), 3u);
  EXPECT_EQ(spec["data"]["values"][1]["x"], "30-50");
  EXPECT_TRUE(spec["data"]["values"][1]["rate"].is_null());
  EXPECT_TRUE(spec["data"]["values"][1]["low"].is_null());
  EXPECT_FALSE(LayersOf(spec, "area")[0].contains("transform")) << "a filter would close the gap";
  ASSERT_EQ(chart.table.size(), 4u);
  EXPECT_THAT(chart.table[2], ElementsAre("30-50", "-", "0"));
}

TEST(RateCurves, ReferenceIsASeparateLayerAndAColumn) {
  const RateCurve curve{"one", std::vector<ReportRate>(3, {1, 2, {0.1, 0.9}})};
  const RateCurve reference{"other", std::vector<ReportRate>(3, {3, 4, {0.4, 0.9}})};
  const ReportChart chart =
      RateCurves({"id", "title", "", ""}, "x", "y", kBands, {curve}, {100, &reference});
  const Json spec = Json::parse(chart.spec);
  EXPECT_EQ(spec["height"], 100);
  EXPECT_EQ(spec["data"]["values"].size(), 3u);
  int own_data = 0;
  for (const Json& layer : spec["layer"]) {
    if (!layer.contains("data")) continue;
    ++own_data;
    EXPECT_EQ(layer["data"]["values"][0]["rate"], 0.75);
  }
  EXPECT_EQ(own_data, 1);
  EXPECT_THAT(chart.table[0], ElementsAre("x", "one [95 %]", "of", "other [95 %]", "of"));
}

// A line between two categories would mean values between them.
TEST(RateCurves, CategoriesArePointsWithBarsSideBySide) {
  const std::vector<ReportRate> halves(3, {1, 2, {0.1, 0.9}});
  const ReportChart chart =
      RateCurves({"id", "title", "", ""}, "x", "y", kBands, {{"one", halves}, {"two", halves}},
                 {.x_names = AxisNames::kCategories});
  const NamedValueCurve value{
      "one", {1, 2, 3}, {{0, 2}, {1, 3}, {2, 4}}, {"1", "2", "3"}, {4, 4, 4}};
  const ReportChart values = NamedValueCurves({"id", "title", "", ""}, "x", "y", kBands, {value}, 1,
                                              AxisNames::kCategories);
  for (const Json& spec : {Json::parse(chart.spec), Json::parse(values.spec)}) {
    EXPECT_TRUE(LayersOf(spec, "line").empty() && LayersOf(spec, "area").empty());
    ASSERT_EQ(LayersOf(spec, "point").size(), 1u);
    ASSERT_EQ(LayersOf(spec, "rule").size(), 1u);
    for (const Json& layer : spec["layer"]) {
      EXPECT_EQ(layer["encoding"]["xOffset"]["field"], "series");
    }
  }
}

TEST(NamedValueCurves, NamesWithoutAValueInterruptTheLineAndHaveARow) {
  const NamedValueCurve curve{"one",
                              {1.5, std::nan(""), 2.5},
                              {{1, 2}, Interval::Unknown(), {2, 3}},
                              {"1.5", "-", "2.5"},
                              {4, 0, 6}};
  const ReportChart chart =
      NamedValueCurves({"id", "title", "", ""}, "x", "y, mm", kBands, {curve});
  const Json spec = Json::parse(chart.spec);
  ASSERT_EQ(spec["data"]["values"].size(), 3u);
  EXPECT_TRUE(spec["data"]["values"][1]["rate"].is_null());
  EXPECT_EQ(spec["data"]["values"][2]["rate"], 2.5);
  EXPECT_EQ(spec["data"]["values"][2]["high"], 3);
  EXPECT_THAT(chart.table[2], ElementsAre("30-50", "-", "0"));
  EXPECT_THAT(chart.caption, testing::Not(HasSubstr("too few bins")));
}

TEST(NamedValueCurves, AxisDoesNotMagnifyRoundingErrors) {
  NamedValueCurve curve{"one", {1e-7}, {{0, 3e-7}}, {"0.0"}, {4}};
  const auto scale_of = [&] {
    const ReportChart chart =
        NamedValueCurves({"id", "title", "", ""}, "x", "y, deg", {"0-10"}, {curve}, 0.5);
    const Json spec = Json::parse(chart.spec);
    return LayersOf(spec, "line")[0]["encoding"]["y"]["scale"];
  };
  EXPECT_EQ(scale_of().value("domainMax", 0.0), 0.5);
  curve.intervals[0].high = 0.6;
  EXPECT_FALSE(scale_of().contains("domainMax")) << "an interval above the limit sets the axis";
}

TEST(CalibrationCurves, PointsAreConfidenceAndRate) {
  const ReportChart chart =
      CalibrationCurves({"id", "title", "", ""}, "stated", "right",
                        {{"one", {{0.25, {1, 4, {0, 0.7}}}, {0.85, {8, 10, {0.5, 0.9}}}}}});
  const Json spec = Json::parse(chart.spec);
  ASSERT_EQ(spec["data"]["values"].size(), 2u);
  EXPECT_EQ(spec["data"]["values"][1]["confidence"], 0.85);
  EXPECT_EQ(spec["data"]["values"][1]["rate"], 0.8);
  EXPECT_THAT(chart.table.back(), ElementsAre("one", "85.0 %", "80.0 % [50.0, 90.0]", "10"));
  EXPECT_TRUE(LayersOf(spec, "area").empty()) << "a band would fill gaps between bins";
}

TEST(ValueCurves, OneRowPerXAndOneColumnPerCurve) {
  const ReportChart chart =
      ValueCurves({"id", "title", "", ""}, "step", "loss",
                  {{"a", {{0, 0.5, 0.5, 0.5}, {10, 0.25, 0.2, 0.3}}}, {"b", {{10, 2, 2, 2}}}}, 3);
  EXPECT_THAT(chart.table, ElementsAre(ElementsAre("step", "a", "b"), ElementsAre("0", "0.5", ""),
                                       ElementsAre("10", "0.25 [0.2, 0.3]", "2")));
  const Json spec = Json::parse(chart.spec);
  EXPECT_EQ(spec["data"]["values"].size(), 3u);
  const Json line = LayersOf(spec, "line").at(0);
  EXPECT_EQ(line["encoding"]["x"]["type"], "quantitative");
  EXPECT_EQ(line["encoding"]["y"]["scale"]["domain"][1], 3);
}

TEST(Curves, EmptyCurvesStateThatNothingWasCounted) {
  const ReportChart empty{"id", "title", "Caption.", ""};
  for (const ReportChart& chart :
       {RateCurves(empty, "x", "y", kBands, {{"one", std::vector<ReportRate>(3)}}),
        CalibrationCurves(empty, "x", "y", {{"one", {}}}), ValueCurves(empty, "x", "y", {})}) {
    EXPECT_EQ(chart.spec, "");
    EXPECT_EQ(chart.caption, "Caption. There was nothing to count.");
  }
}

}  // namespace
}  // namespace pickbed::tests
