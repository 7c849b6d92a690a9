#include "eval/report/charts_impl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace pickbed {
namespace {

// Told apart by colour-blind readers too (Okabe and Ito 2008), on white and on black paper.
constexpr std::array kColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                             "#e69f00", "#56b4e9", "#999999"};
constexpr std::array kShapes{"circle", "square",        "triangle-up", "diamond",
                             "cross",  "triangle-down", "stroke"};
const std::vector<std::vector<int>> kDashes{{},     {6, 3},  {2, 2},      {8, 3, 2, 3},
                                            {1, 3}, {10, 4}, {4, 2, 1, 2}};

// Values are used again after the last, moved on by `turn`: colour and dash together are then seen
// once only in 49 series.
template <typename Values>
Json Scale(const std::vector<std::string>& names, const Values& values, size_t turn = 0) {
  Json range = Json::array();
  for (size_t i = 0; i < names.size(); ++i) {
    range.push_back(values[(i + turn * (i / values.size())) % values.size()]);
  }
  return {{"domain", names}, {"range", range}};
}

Json Series(const char* field, const std::vector<std::string>& names, Json scale) {
  Json channel = Field(field, "nominal", "");
  channel["scale"] = std::move(scale);
  channel["title"] = nullptr;
  if (names.size() < 2) {
    channel["legend"] = nullptr;
  } else {
    channel["legend"] = {{"orient", "top"}, {"direction", "vertical"}};
  }
  return channel;
}

}  // namespace

Json Field(const char* name, const char* type, const std::string& title) {
  return {{"field", name}, {"type", type}, {"title", title}};
}

Json PercentField(const char* name, const std::string& title, bool whole) {
  Json field = Field(name, "quantitative", title);
  field["axis"] = {{"format", "~%"}, {"tickCount", 5}};
  if (whole) field["scale"] = {{"domain", {0, 1}}};
  return field;
}

Json EmptySpec(const Json& values) {
  return {{"$schema", "https://vega.github.io/schema/vega-lite/v5.json"},
          {"width", "container"},
          {"autosize", {{"type", "fit-x"}, {"contains", "padding"}}},
          {"data", {{"values", values}}}};
}

int BarsHeight_px(size_t rows, size_t series) {
  constexpr size_t kRow_px = 26, kBar_px = 14;
  return static_cast<int>(rows * std::max(kRow_px, kBar_px * series + kBar_px / 2));
}

std::vector<std::string> NamesOf(std::span<const PointReport> points) {
  std::vector<std::string> names;
  for (const PointReport& point : points) names.push_back(point.name);
  return names;
}

Json SeriesColor(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kColors));
}

Json SeriesShape(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kShapes, 1));
}

Json SeriesDash(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kDashes, 1));
}

// The patterns are drawn by the page (page.html), which shows charts as SVG.
Json SeriesFill(const char* field, const std::vector<std::string>& names) {
  std::vector<std::string> patterns;
  for (size_t i = 0; i < kColors.size(); ++i) patterns.push_back(fmt::format("url(#fill-{})", i));
  return Series(field, names, Scale(names, patterns));
}

Json CurveLayers(const Json& x, const Json& y, const std::vector<std::string>& names) {
  Json low = y, high = y, sort = x;
  low["field"] = "low";
  high = {{"field", "high"}};
  const Json color = SeriesColor("series", names);
  Json layers = Json::array();
  layers.push_back({{"mark", {{"type", "area"}, {"opacity", 0.15}}},
                    {"encoding", {{"x", x}, {"y", low}, {"y2", high}, {"color", color}}}});
  layers.push_back({{"mark", {{"type", "rule"}, {"opacity", 0.6}}},
                    {"encoding", {{"x", x}, {"y", low}, {"y2", high}, {"color", color}}}});
  layers.push_back(
      {{"mark", {{"type", "line"}, {"strokeWidth", 2}}},
       {"encoding",
        {{"x", x}, {"y", y}, {"color", color}, {"strokeDash", SeriesDash("series", names)}}}});
  layers.push_back({{"mark", {{"type", "point"}, {"filled", true}, {"size", 70}}},
                    {"encoding",
                     {{"x", x},
                      {"y", y},
                      {"color", color},
                      {"shape", SeriesShape("series", names)},
                      {"tooltip",
                       {{{"field", "series"}, {"type", "nominal"}},
                        {{"field", "text"}, {"type", "nominal"}, {"title", "rate"}}}}}}});
  return layers;
}

namespace {

// Names that do not fit beside each other are slanted, all of them, rather than left out.
Json NamesAxis(const std::vector<std::string>& names) {
  constexpr size_t kLevelLetters = 40;
  constexpr int kSlant_deg = -40;
  size_t letters = 0;
  for (const std::string& name : names) letters += name.size();
  if (letters <= kLevelLetters) return {{"labelAngle", 0}};
  return {{"labelAngle", kSlant_deg}, {"labelOverlap", false}};
}

}  // namespace

ReportChart RateCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                       const std::vector<std::string>& x_names,
                       const std::vector<RateCurve>& curves) {
  Json values = Json::array();
  std::vector<std::string> names;
  chart.table = {{x_title}};
  for (const std::string& x : x_names) chart.table.push_back({x});
  for (const RateCurve& curve : curves) {
    names.push_back(curve.series);
    chart.table[0].push_back(curve.series + " [95 %]");
    chart.table[0].push_back("of");
    for (size_t i = 0; i < x_names.size(); ++i) {
      const ReportRate& rate = curve.rates[i];
      chart.table[i + 1].push_back(RateText(rate));
      chart.table[i + 1].push_back(std::to_string(rate.tries));
      if (rate.tries == 0) continue;
      values.push_back({{"x", x_names[i]},
                        {"series", curve.series},
                        {"rate", rate.rate()},
                        {"low", rate.ci95.low},
                        {"high", rate.ci95.high},
                        {"text", fmt::format("{} of {}", RateText(rate), rate.tries)}});
    }
  }
  if (values.empty()) {
    chart.caption += " There was nothing to count.";
    return chart;
  }
  Json spec = EmptySpec(values);
  Json x = Field("x", "ordinal", x_title);
  x["sort"] = x_names;
  x["scale"] = {{"domain", x_names}};
  x["axis"] = NamesAxis(x_names);
  spec["height"] = 260;
  spec["layer"] = CurveLayers(x, PercentField("rate", y_title), names);
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed
