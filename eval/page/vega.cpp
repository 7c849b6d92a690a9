#include "eval/page/vega.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace pickbed::eval {
namespace {

// Colors that are also distinguishable for color-blind readers (Okabe and Ito 2008), on white and
// on black paper.
constexpr std::array kSeriesColors{"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                   "#e69f00", "#56b4e9", "#999999"};
constexpr std::array kShapes{"circle", "square",        "triangle-up", "diamond",
                             "cross",  "triangle-down", "stroke"};
const std::vector<std::vector<int>> kDashes{{},     {6, 3},  {2, 2},      {8, 3, 2, 3},
                                            {1, 3}, {10, 4}, {4, 2, 1, 2}};

// Values repeat after the last one, shifted by `turn`. Combinations of color and dash are therefore
// unique for 49 series.
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
    // If a name of a configuration is long, all of them have one line per setting.
    constexpr size_t kLong = 34;
    const bool long_names = std::any_of(
        names.begin(), names.end(), [](const std::string& name) { return name.size() > kLong; });
    channel["legend"] = {{"orient", "top"}, {"direction", "vertical"}};
    if (long_names) channel["legend"]["labelExpr"] = "split(datum.label, ',')";
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

Json SeriesColor(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kSeriesColors));
}

Json SeriesShape(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kShapes, 1));
}

Json SeriesDash(const char* field, const std::vector<std::string>& names) {
  return Series(field, names, Scale(names, kDashes, 1));
}

// The page template (page.html) defines the patterns and shows charts as SVG.
Json SeriesFill(const char* field, const std::vector<std::string>& names) {
  std::vector<std::string> patterns;
  for (size_t i = 0; i < kSeriesColors.size(); ++i)
    patterns.push_back(fmt::format("url(#fill-{})", i));
  return Series(field, names, Scale(names, patterns));
}

void AddRate(const ReportRate& rate, Json& value) {
  value["rate"] = rate.rate();
  if (rate.ci95.is_known()) {
    value["low"] = rate.ci95.low;
    value["high"] = rate.ci95.high;
  }
  value["text"] = fmt::format("{} of {}", RateText(rate), rate.samples);
}

Json WithInterval(Json layer) {
  layer["transform"] = {{{"filter", "isValid(datum.low)"}}};
  return layer;
}

Json CurveLayers(const Json& x, const Json& y, const std::vector<std::string>& names) {
  Json low = y, high = y, sort = x;
  low["field"] = "low";
  high = {{"field", "high"}};
  const Json color = SeriesColor("series", names);
  Json layers = Json::array();
  layers.push_back({{"mark", {{"type", "area"}, {"opacity", 0.15}}},
                    {"encoding", {{"x", x}, {"y", low}, {"y2", high}, {"color", color}}}});
  layers.push_back(
      WithInterval({{"mark", {{"type", "rule"}, {"opacity", 0.6}}},
                    {"encoding", {{"x", x}, {"y", low}, {"y2", high}, {"color", color}}}}));
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

Json PointLayers(const Json& x, const Json& y, const std::vector<std::string>& names) {
  Json offset = Field("series", "nominal", "");
  offset["sort"] = names;
  Json layers = CurveLayers(x, y, names);
  std::erase_if(layers.get_ref<Json::array_t&>(), [](const Json& layer) {
    return layer["mark"]["type"] == "area" || layer["mark"]["type"] == "line";
  });
  for (Json& layer : layers) layer["encoding"]["xOffset"] = offset;
  return layers;
}

namespace {

Json LayersOf(AxisNames kind, const Json& x, const Json& y, const std::vector<std::string>& names) {
  return kind == AxisNames::kOrdered ? CurveLayers(x, y, names) : PointLayers(x, y, names);
}

constexpr int kSmall_px = 200;  // a chart of less height is also narrow
constexpr const char* kNothingCounted = " There was nothing to count.";

// If the names do not fit side by side, all of them are slanted, so that none is left out.
Json NamesAxis(const std::vector<std::string>& names, int height_px) {
  constexpr size_t kLevelLetters = 40;
  constexpr int kSlant_deg = -40;
  size_t letters = 0;
  for (const std::string& name : names) letters += name.size();
  if (letters <= kLevelLetters && height_px < kSmall_px) {
    return {{"labelAngle", 0}, {"labelFontSize", 9.5}, {"labelOverlap", false}};
  }
  if (letters <= kLevelLetters) return {{"labelAngle", 0}};
  return {{"labelAngle", kSlant_deg}, {"labelOverlap", false}};
}

// Data values of a curve, in the order of the names. A name without samples has no rate, which
// interrupts the line.
void AddValues(const RateCurve& curve, const std::vector<std::string>& x_names, Json& values) {
  for (size_t i = 0; i < x_names.size(); ++i) {
    const ReportRate& rate = curve.rates[i];
    values.push_back(
        {{"x", x_names[i]}, {"series", curve.series}, {"rate", nullptr}, {"low", nullptr}});
    if (rate.samples == 0) continue;
    values.back().erase("low");
    AddRate(rate, values.back());
  }
}

void AddColumns(const RateCurve& curve, TableCells& table) {
  table[0].insert(table[0].end(), {curve.series + " [95 %]", "of"});
  for (size_t i = 0; i + 1 < table.size(); ++i) {
    const ReportRate& rate = curve.rates[i];
    table[i + 1].insert(table[i + 1].end(), {RateText(rate), std::to_string(rate.samples)});
  }
}

bool AnyWithoutInterval(const Json& values) {
  return std::any_of(values.begin(), values.end(),
                     [](const Json& value) { return !value.contains("low"); });
}

bool HasRates(const Json& values) {
  return std::any_of(values.begin(), values.end(),
                     [](const Json& value) { return !value["rate"].is_null(); });
}

// Gray line and points. The data of the layer are its own.
Json ReferenceLayer(const Json& x, const Json& y, const Json& values) {
  return {{"data", {{"values", values}}},
          {"mark",
           {{"type", "line"},
            {"color", "currentColor"},
            {"opacity", 0.4},
            {"point", {{"color", "currentColor"}, {"opacity", 0.4}, {"size", 30}}}}},
          {"encoding", {{"x", x}, {"y", y}}}};
}

Json DiagonalLayer(const Json& x, const Json& y) {
  const Json ends =
      Json::array({{{"confidence", 0}, {"rate", 0}}, {{"confidence", 1}, {"rate", 1}}});
  return {{"data", {{"values", ends}}},
          {"mark",
           {{"type", "line"}, {"color", "currentColor"}, {"opacity", 0.5}, {"strokeDash", {2, 3}}}},
          {"encoding", {{"x", x}, {"y", y}}}};
}

}  // namespace

ReportChart RateCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                       const std::vector<std::string>& x_names,
                       const std::vector<RateCurve>& curves, const RateCurvesStyle& style) {
  Json values = Json::array();
  std::vector<std::string> names;
  chart.table = {{x_title}};
  for (const std::string& x : x_names) chart.table.push_back({x});
  for (const RateCurve& curve : curves) {
    names.push_back(curve.series);
    AddColumns(curve, chart.table);
    AddValues(curve, x_names, values);
  }
  if (!HasRates(values)) {
    chart.caption += kNothingCounted;
    return chart;
  }
  if (AnyWithoutInterval(values)) SayTooFewBins(chart.caption);
  Json spec = EmptySpec(values);
  Json x = Field("x", "ordinal", x_title);
  x["sort"] = x_names;
  x["scale"] = {{"domain", x_names}};
  x["axis"] = NamesAxis(x_names, style.height_px);
  const Json y = PercentField("rate", y_title);
  Json layers = LayersOf(style.x_names, x, y, names);
  if (style.reference != nullptr) {
    AddColumns(*style.reference, chart.table);
    Json reference = Json::array();
    AddValues(*style.reference, x_names, reference);
    layers.insert(layers.begin(), ReferenceLayer(x, y, reference));
  }
  spec["height"] = style.height_px;
  spec["layer"] = std::move(layers);
  chart.spec = spec.dump();
  return chart;
}

ReportChart NamedValueCurves(ReportChart chart, const std::string& x_title,
                             const std::string& y_title, const std::vector<std::string>& x_names,
                             const std::vector<NamedValueCurve>& curves, double min_y_end,
                             AxisNames kind) {
  constexpr int kHeight_px = 220;
  Json values = Json::array();
  std::vector<std::string> names;
  double largest = 0;
  chart.table = {{x_title}};
  for (const std::string& x : x_names) chart.table.push_back({x});
  for (const NamedValueCurve& curve : curves) {
    names.push_back(curve.series);
    chart.table[0].insert(chart.table[0].end(), {curve.series + " [95 %]", "of"});
    for (size_t i = 0; i < x_names.size(); ++i) {
      chart.table[i + 1].insert(chart.table[i + 1].end(),
                                {curve.texts[i], std::to_string(curve.samples[i])});
      values.push_back(
          {{"x", x_names[i]}, {"series", curve.series}, {"rate", nullptr}, {"low", nullptr}});
      if (!std::isfinite(curve.values[i])) continue;
      values.back().erase("low");
      values.back()["rate"] = curve.values[i];
      values.back()["text"] = curve.texts[i];
      largest = std::max(largest, curve.values[i]);
      const Interval& ci95 = curve.intervals[i];
      if (!std::isfinite(ci95.low) || !std::isfinite(ci95.high)) continue;
      values.back()["low"] = ci95.low;
      values.back()["high"] = ci95.high;
      largest = std::max(largest, ci95.high);
    }
  }
  if (!HasRates(values)) {
    chart.caption += kNothingCounted;
    return chart;
  }
  if (AnyWithoutInterval(values)) SayTooFewBins(chart.caption);
  Json x = Field("x", "ordinal", x_title);
  x["sort"] = x_names;
  x["scale"] = {{"domain", x_names}};
  x["axis"] = NamesAxis(x_names, kHeight_px);
  Json y = Field("rate", "quantitative", y_title);
  y["axis"] = {{"tickCount", 5}};
  y["scale"] = {{"zero", true}};
  if (largest < min_y_end) y["scale"]["domainMax"] = min_y_end;
  Json spec = EmptySpec(values);
  spec["height"] = kHeight_px;
  spec["layer"] = LayersOf(kind, x, y, names);
  chart.spec = spec.dump();
  return chart;
}

ReportChart CalibrationCurves(ReportChart chart, const std::string& x_title,
                              const std::string& y_title,
                              const std::vector<CalibrationCurve>& curves) {
  Json values = Json::array();
  std::vector<std::string> names;
  for (const CalibrationCurve& curve : curves) {
    names.push_back(curve.series);
    for (const auto& [confidence, right] : curve.points) {
      chart.table.push_back(
          {curve.series, PercentText(confidence), RateText(right), std::to_string(right.samples)});
      values.push_back({{"confidence", confidence}, {"series", curve.series}});
      AddRate(right, values.back());
    }
  }
  if (values.empty()) {
    chart.caption += kNothingCounted;
    return chart;
  }
  if (AnyWithoutInterval(values)) SayTooFewBins(chart.caption);
  const Json x = PercentField("confidence", x_title), y = PercentField("rate", y_title);
  Json spec = EmptySpec(values);
  Json layers = CurveLayers(x, y, names);
  layers.erase(0);  // keep only the bars: confidence bins may be far apart
  layers.insert(layers.begin(), DiagonalLayer(x, y));
  spec["height"] = 300;
  spec["layer"] = layers;
  chart.spec = spec.dump();
  return chart;
}

ReportChart ValueCurves(ReportChart chart, const std::string& x_title, const std::string& y_title,
                        const std::vector<ValueCurve>& curves, double y_max) {
  Json values = Json::array();
  std::vector<std::string> names;
  std::map<double, std::vector<std::string>> rows;  // of the table, by x
  chart.table = {{x_title}};
  for (const ValueCurve& curve : curves) {
    names.push_back(curve.series);
    chart.table[0].push_back(curve.series);
    for (const ValuePoint& point : curve.points) {
      const std::string text = point.low < point.high ? fmt::format("{:.4g} [{:.4g}, {:.4g}]",
                                                                    point.y, point.low, point.high)
                                                      : fmt::format("{:.4g}", point.y);
      std::vector<std::string>& row = rows[point.x];
      row.resize(names.size());
      row.back() = text;
      values.push_back({{"x", point.x},
                        {"series", curve.series},
                        {"rate", point.y},
                        {"low", point.low},
                        {"high", point.high},
                        {"text", text}});
    }
  }
  for (auto& [at, row] : rows) {
    row.resize(names.size());
    row.insert(row.begin(), fmt::format("{:g}", at));
    chart.table.push_back(std::move(row));
  }
  if (values.empty()) {
    chart.caption += kNothingCounted;
    return chart;
  }
  Json x = Field("x", "quantitative", x_title);
  x["axis"] = {{"tickCount", 6}};
  x["scale"] = {{"nice", false}};
  Json y = Field("rate", "quantitative", y_title);
  y["axis"] = {{"tickCount", 5}};
  if (y_max > 0) y["scale"] = {{"domain", {0, y_max}}};
  Json spec = EmptySpec(values);
  Json layers = CurveLayers(x, y, names);
  layers.erase(1);  // the band shows the ranges
  spec["height"] = 260;
  spec["layer"] = std::move(layers);
  chart.spec = spec.dump();
  return chart;
}

}  // namespace pickbed::eval
