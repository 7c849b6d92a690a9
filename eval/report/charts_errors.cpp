#include <fmt/format.h>

#include "eval/report/charts_impl.h"

namespace pickbed {
namespace {

constexpr const char* kRight = "right pose";
constexpr const char* kWrong = "wrong pose";

std::string BinText(const ErrorBin& bin) {
  return fmt::format("{:.4g} to {:.4g}", bin.low, bin.high);
}

std::string CaptionOf(std::span<const PointReport> points, size_t error, const PoseErrorRow& row) {
  std::string caption;
  for (const PointReport& point : points) {
    const ErrorHistogram& histogram = point.errors[error];
    const std::string name = points.size() > 1 ? point.name + ": " : "";
    if (histogram.total == 0) {
      caption += fmt::format("{}no poses. ", name);
      continue;
    }
    const double beyond = 100.0 * histogram.beyond / histogram.total;
    caption += fmt::format(
        "{}median {} {} of {} poses{}. ", name, MedianText(histogram.median, row.digits), row.unit,
        histogram.total, histogram.beyond > 0 ? fmt::format("; {:.1f} % lie beyond", beyond) : "");
  }
  if (points.size() == 1) caption.front() = static_cast<char>(std::toupper(caption.front()));
  return caption + "In brackets: 95 % intervals, with scenes as units.";
}

// One point: bars, right poses below wrong ones.
Json BarSpec(const ErrorHistogram& histogram, const std::string& x_title) {
  Json values = Json::array();
  for (const ErrorBin& bin : histogram.bins) {
    // Stacked here: Vega-Lite stacks no bars that have both ends of x.
    const auto add = [&](int from, int poses, const char* series) {
      values.push_back({{"low", bin.low},
                        {"high", bin.high},
                        {"from", from},
                        {"to", from + poses},
                        {"poses", poses},
                        {"series", series}});
    };
    add(0, bin.right, kRight);
    add(bin.right, bin.wrong, kWrong);
  }
  Json spec = EmptySpec(values);
  Json x = Field("low", "quantitative", x_title);
  x["scale"] = {{"domain", {0, histogram.bins.back().high}}, {"nice", false}};
  x["axis"] = {{"tickCount", 6}};
  spec["height"] = 200;
  spec["mark"] = {{"type", "bar"}, {"stroke", "currentColor"}, {"strokeWidth", 0.4}};
  spec["encoding"] = {{"x", x},
                      {"x2", {{"field", "high"}}},
                      {"y", Field("to", "quantitative", "poses")},
                      {"y2", {{"field", "from"}}},
                      {"fill", SeriesFill("series", {kRight, kWrong})}};
  return spec;
}

// Several: the outline of each, as shares, since they may differ in number.
Json StepSpec(std::span<const PointReport> points, size_t error, const std::string& x_title) {
  Json values = Json::array();
  for (const PointReport& point : points) {
    const ErrorHistogram& histogram = point.errors[error];
    // A corner of the outline, which begins and ends on the axis.
    int corner = 0;
    const auto add = [&](double at, double share) {
      values.push_back(
          {{"low", at}, {"share", share}, {"series", point.name}, {"corner", corner++}});
    };
    add(histogram.bins.front().low, 0);
    for (const ErrorBin& bin : histogram.bins) {
      add(bin.low,
          histogram.total > 0 ? static_cast<double>(bin.right + bin.wrong) / histogram.total : 0);
    }
    add(histogram.bins.back().high, 0);
  }
  Json x = Field("low", "quantitative", x_title);
  x["scale"] = {{"domain", {0, points[0].errors[error].bins.back().high}}, {"nice", false}};
  x["axis"] = {{"tickCount", 6}};
  const std::vector<std::string> names = NamesOf(points);
  Json spec = EmptySpec(values);
  spec["height"] = 200;
  spec["mark"] = {{"type", "line"}, {"interpolate", "step-after"}, {"strokeWidth", 2}};
  spec["encoding"] = {{"x", x},
                      {"order", {{"field", "corner"}, {"type", "quantitative"}}},
                      {"y", PercentField("share", "share of poses", false)},
                      {"color", SeriesColor("series", names)},
                      {"strokeDash", SeriesDash("series", names)}};
  return spec;
}

TableCells CellsOf(std::span<const PointReport> points, size_t error, const PoseErrorRow& row) {
  TableCells cells{{row.unit}};
  for (const PointReport& point : points) {
    const std::string prefix = points.size() > 1 ? point.name + ": " : "";
    cells[0].push_back(prefix + kRight);
    cells[0].push_back(prefix + kWrong);
  }
  for (size_t i = 0; i < points[0].errors[error].bins.size(); ++i) {
    cells.push_back({BinText(points[0].errors[error].bins[i])});
    for (const PointReport& point : points) {
      cells.back().push_back(std::to_string(point.errors[error].bins[i].right));
      cells.back().push_back(std::to_string(point.errors[error].bins[i].wrong));
    }
  }
  return cells;
}

}  // namespace

std::vector<ReportChart> ErrorCharts(std::span<const PointReport> points) {
  std::vector<ReportChart> charts;
  for (const PoseErrorRow& row : PoseErrorTable()) {
    const auto error = static_cast<size_t>(row.error);
    ReportChart& chart = charts.emplace_back();
    chart.id = fmt::format("error-{}", error);
    chart.title = fmt::format("Pose error: {}", row.name);
    int poses = 0;
    for (const PointReport& point : points) poses += point.errors[error].total;
    if (poses == 0) {
      chart.caption = "No pose was reported.";
      continue;
    }
    const std::string x_title = fmt::format("{}, {}", row.name, row.unit);
    chart.caption = CaptionOf(points, error, row);
    chart.table = CellsOf(points, error, row);
    chart.spec = (points.size() == 1 ? BarSpec(points[0].errors[error], x_title)
                                     : StepSpec(points, error, x_title))
                     .dump();
  }
  return charts;
}

}  // namespace pickbed
