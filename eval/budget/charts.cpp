#include "eval/budget/charts.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/page/vega.h"

namespace pickbed::eval {
namespace {

constexpr const char* kAllColor = "#66737f";
constexpr const char* kLeftColor = "#007a5a";
// The bars end at 1. The texts are in a column behind them.
constexpr double kTextAt = 1.02, kEndOfText = 1.28;

// A bar of the waterfall in shares: its ends, the interval of the end that its count decides, and
// the text beside it.
struct Bar {
  std::string label, kind;
  double from = 0, to = 0;
  double low = 0, high = 0;  // low = high: no interval
  std::string text;
};

Json ValueOf(const Bar& bar) {
  return {{"name", bar.label}, {"kind", bar.kind}, {"from", bar.from}, {"to", bar.to},
          {"low", bar.low},    {"high", bar.high}, {"text", bar.text}, {"at", kTextAt}};
}

std::string StepText(int count, int total) {
  return fmt::format("{} ({})", count, PercentText(count, total));
}

std::vector<Bar> BarsOf(const Waterfall& waterfall) {
  const double total = std::max(1, waterfall.total);
  std::vector<Bar> bars{{waterfall.all, "all", 0, 1, 1, 1, fmt::format("{}", waterfall.total)}};
  int left = waterfall.total;
  for (const WaterfallStep& step : waterfall.steps) {
    const double before = left / total;
    left -= step.count;
    const double end = left / total;
    const Interval line = step.ci95.is_known() ? Interval{std::max(0.0, before - step.ci95.high),
                                                          before - step.ci95.low}
                                               : Interval{end, end};
    bars.push_back({step.group + ": " + step.name, step.group, end, before, line.low, line.high,
                    StepText(step.count, waterfall.total)});
  }
  const WaterfallStep& picked = waterfall.left;
  const double end = picked.count / total;
  const Interval line = picked.ci95.is_known() ? picked.ci95 : Interval{end, end};
  bars.push_back(
      {picked.name, "left", 0, end, line.low, line.high, StepText(picked.count, waterfall.total)});
  return bars;
}

// Colors and patterns of the stages, and colors of the first and the last bar.
Json FillOf(const Waterfall& waterfall) {
  std::vector<std::string> stages;
  for (const WaterfallStep& step : waterfall.steps) {
    if (std::find(stages.begin(), stages.end(), step.group) == stages.end()) {
      stages.push_back(step.group);
    }
  }
  Json fill = SeriesFill("kind", stages);
  fill["legend"] = nullptr;  // the names of the bars have the stage
  for (const auto& [kind, color] : {std::pair("all", kAllColor), std::pair("left", kLeftColor)}) {
    fill["scale"]["domain"].push_back(kind);
    fill["scale"]["range"].push_back(color);
  }
  return fill;
}

Json NamesOnY(const std::vector<std::string>& names) {
  Json y = Field("name", "nominal", "");
  y["sort"] = names;
  y["title"] = nullptr;
  return y;
}

}  // namespace

std::string GainText(const Gain& gain) { return PointsText(gain.after - gain.before, gain.rise); }

ReportChart WaterfallChart(const std::string& id, const Waterfall& waterfall) {
  ReportChart chart{id, waterfall.title,
                    "Each bar begins where the one above it ends. Lines: 95 % intervals of the "
                    "bar's end, over bins.",
                    ""};
  if (!waterfall.left.ci95.is_known()) SayTooFewBins(chart.caption);
  chart.table = {{"", "stage", "number", "share [95 %]"},
                 {waterfall.all, "", std::to_string(waterfall.total), ""}};
  const auto add = [&](const WaterfallStep& step) {
    chart.table.push_back({step.name, step.group, std::to_string(step.count),
                           RateText({step.count, waterfall.total, step.ci95})});
  };
  for (const WaterfallStep& step : waterfall.steps) add(step);
  add(waterfall.left);
  Json values = Json::array();
  std::vector<std::string> names;
  for (const Bar& bar : BarsOf(waterfall)) {
    names.push_back(bar.label);
    values.push_back(ValueOf(bar));
  }
  const Json y = NamesOnY(names);
  Json x = PercentField("from", "share of " + waterfall.whole);
  x["axis"]["values"] = {0, 0.2, 0.4, 0.6, 0.8, 1};
  x["axis"]["tickCount"] = 6;  // Vega leaves out values beyond this number
  x["scale"] = {{"domain", {0, kEndOfText}}};
  Json low = x, text = x;
  low["field"] = "low";
  text["field"] = "at";
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(names.size(), 1);
  spec["layer"] = {
      {{"mark", {{"type", "bar"}}},
       {"encoding",
        {{"y", y},
         {"x", x},
         {"x2", {{"field", "to"}}},
         {"fill", FillOf(waterfall)},
         {"tooltip",
          {{{"field", "name"}, {"type", "nominal"}}, {{"field", "text"}, {"type", "nominal"}}}}}}},
      {{"mark", {{"type", "rule"}, {"color", "currentColor"}, {"strokeWidth", 1.5}}},
       {"encoding", {{"y", y}, {"x", low}, {"x2", {{"field", "high"}}}}}},
      {{"mark", {{"type", "text"}, {"align", "left"}}},
       {"encoding", {{"y", y}, {"x", text}, {"text", {{"field", "text"}, {"type", "nominal"}}}}}}};
  chart.spec = spec.dump();
  return chart;
}

ReportChart GainsChart(const std::string& id, const GainRows& gains) {
  ReportChart chart{id, gains.title, "Lines: paired 95 % intervals over bins.", ""};
  chart.table = {{"", gains.first + " [95 %]", gains.second + " [95 %]"}};
  Json values = Json::array();
  std::vector<std::string> names;
  bool few = false;
  for (const GainRow& row : gains.rows) {
    names.push_back(row.name);
    std::vector<std::string>& cells = chart.table.emplace_back(std::vector{row.name});
    const auto add = [&](const Gain& gain, const std::string& series) {
      cells.push_back(GainText(gain));
      const bool known = gain.rise.is_known();
      few = few || !known;
      values.push_back({{"name", row.name},
                        {"series", series},
                        {"gain", gain.points()},
                        {"low", known ? 100 * gain.rise.low : gain.points()},
                        {"high", known ? 100 * gain.rise.high : gain.points()},
                        {"text", cells.back()}});
    };
    add(row.first, gains.first);
    add(row.second, gains.second);
  }
  if (values.empty()) return chart;
  if (few) SayTooFewBins(chart.caption);
  const std::vector<std::string> series{gains.first, gains.second};
  Json x = Field("gain", "quantitative", "gain, percentage points");
  x["axis"] = {{"tickCount", 8}};
  Json point{{"y", NamesOnY(names)},
             {"x", x},
             {"yOffset", {{"field", "series"}, {"type", "nominal"}, {"sort", series}}},
             {"color", SeriesColor("series", series)}};
  Json line = point;
  line["x"]["field"] = "low";
  line["x2"] = {{"field", "high"}};
  point["shape"] = SeriesShape("series", series);
  point["tooltip"] = {{{"field", "name"}, {"type", "nominal"}},
                      {{"field", "series"}, {"type", "nominal"}},
                      {{"field", "text"}, {"type", "nominal"}, {"title", "gain"}}};
  Json zero = x;
  zero["field"] = "zero";
  Json spec = EmptySpec(values);
  spec["height"] = BarsHeight_px(names.size(), series.size());
  spec["layer"] = {
      {{"data", {{"values", {{{"zero", 0}}}}}},
       {"mark", {{"type", "rule"}, {"color", "currentColor"}, {"opacity", 0.5}}},
       {"encoding", {{"x", zero}}}},
      {{"mark", {{"type", "rule"}, {"strokeWidth", 2}}}, {"encoding", line}},
      {{"mark", {{"type", "point"}, {"filled", true}, {"size", 70}}}, {"encoding", point}}};
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed::eval
