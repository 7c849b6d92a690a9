#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/page/vega.h"
#include "eval/report/charts.h"

namespace pickbed::eval {
namespace {

constexpr const char* kRight = "right pose";
constexpr const char* kWrong = "wrong pose";

std::string BinText(const ErrorBin& bin) {
  return fmt::format("{:.4g} to {:.4g}", bin.low, bin.high);
}

std::string CaptionOf(std::span<const ConfigurationReport> configurations, size_t error) {
  std::string caption;
  for (const ConfigurationReport& configuration : configurations) {
    const ErrorHistogram& histogram = configuration.errors[error];
    const std::string name = configurations.size() > 1 ? configuration.name + ": " : "";
    if (histogram.total == 0) {
      caption += fmt::format("{}no poses. ", name);
      continue;
    }
    caption += fmt::format(
        "{}median {} {} of {} poses{}. ", name, MedianText(histogram.median, histogram.digits),
        histogram.unit, histogram.total,
        histogram.beyond > 0 ? fmt::format("; {} are beyond the last bin",
                                           PercentText(histogram.beyond, histogram.total))
                             : "");
  }
  if (configurations.size() == 1)
    caption.front() = static_cast<char>(std::toupper(caption.front()));
  return caption + "In brackets: 95 % intervals over bins.";
}

// One configuration: bars, correct poses below wrong ones.
Json BarSpec(const ErrorHistogram& histogram, const std::string& x_title) {
  Json values = Json::array();
  for (const ErrorBin& bin : histogram.bins) {
    // Stacked here, because Vega-Lite does not stack bars with two x ends.
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

// Several configurations: outlines of shares, because numbers of poses may differ.
Json StepSpec(std::span<const ConfigurationReport> configurations, size_t error,
              const std::string& x_title) {
  Json values = Json::array();
  for (const ConfigurationReport& configuration : configurations) {
    const ErrorHistogram& histogram = configuration.errors[error];
    // Adds a corner of the outline, which begins and ends on the axis.
    int corner = 0;
    const auto add = [&](double at, double share) {
      values.push_back(
          {{"low", at}, {"share", share}, {"series", configuration.name}, {"corner", corner++}});
    };
    add(histogram.bins.front().low, 0);
    for (const ErrorBin& bin : histogram.bins) {
      add(bin.low,
          histogram.total > 0 ? static_cast<double>(bin.right + bin.wrong) / histogram.total : 0);
    }
    add(histogram.bins.back().high, 0);
  }
  Json x = Field("low", "quantitative", x_title);
  x["scale"] = {{"domain", {0, configurations[0].errors[error].bins.back().high}}, {"nice", false}};
  x["axis"] = {{"tickCount", 6}};
  const std::vector<std::string> names = NamesOf(configurations);
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

TableCells CellsOf(std::span<const ConfigurationReport> configurations, size_t error) {
  TableCells cells{{configurations[0].errors[error].unit}};
  for (const ConfigurationReport& configuration : configurations) {
    const std::string prefix = configurations.size() > 1 ? configuration.name + ": " : "";
    cells[0].push_back(prefix + kRight);
    cells[0].push_back(prefix + kWrong);
  }
  for (size_t i = 0; i < configurations[0].errors[error].bins.size(); ++i) {
    cells.push_back({BinText(configurations[0].errors[error].bins[i])});
    for (const ConfigurationReport& configuration : configurations) {
      cells.back().push_back(std::to_string(configuration.errors[error].bins[i].right));
      cells.back().push_back(std::to_string(configuration.errors[error].bins[i].wrong));
    }
  }
  return cells;
}

// Medians of one error by band; bands that the configuration does not have stay empty.
NamedValueCurve MediansByBand(const ConfigurationReport& configuration, size_t error,
                              const std::vector<VisibleBand>& bands) {
  NamedValueCurve curve{configuration.name, std::vector<double>(bands.size(), std::nan("")),
                        std::vector<Interval>(bands.size(), Interval::Unknown()),
                        std::vector<std::string>(bands.size(), "-"),
                        std::vector<int>(bands.size())};
  const ErrorHistogram& histogram = configuration.errors[error];
  for (size_t i = 0; i < histogram.by_band.size(); ++i) {
    const BandError& of_band = histogram.by_band[i];
    const auto place =
        std::find(bands.begin(), bands.end(), configuration.bands[i].band) - bands.begin();
    curve.values[place] = of_band.median.value;
    curve.intervals[place] = of_band.median.ci95;
    curve.texts[place] = MedianText(of_band.median, histogram.digits);
    curve.samples[place] = of_band.poses;
  }
  return curve;
}

std::string UnitTitle(const ErrorHistogram& histogram) {
  return fmt::format("{}{}{}", histogram.title, histogram.unit.empty() ? "" : ", ", histogram.unit);
}

}  // namespace

std::vector<ReportChart> ErrorByBandCharts(std::span<const ConfigurationReport> configurations) {
  std::vector<ReportChart> charts;
  const std::vector<VisibleBand> bands = BandsOfAll(configurations);
  std::vector<std::string> names;
  for (const VisibleBand& band : bands) names.push_back(band.name());
  for (size_t error = 0; error < configurations[0].errors.size(); ++error) {
    const ErrorHistogram& first = configurations[0].errors[error];
    std::vector<NamedValueCurve> curves;
    for (const ConfigurationReport& configuration : configurations) {
      curves.push_back(MediansByBand(configuration, error, bands));
      if (configurations.size() == 1) curves.back().series = "median " + first.title;
    }
    charts.push_back(NamedValueCurves(
        {fmt::format("error-by-band-{}", error),
         fmt::format("Pose error by visible fraction: {}", first.title),
         "Median over the reported poses of the instances in each band, right and wrong. Bars: "
         "95 % intervals over bins.",
         ""},
        "visible fraction of the instance, %", "median " + UnitTitle(first), names, curves,
        first.bins.empty() ? 0 : first.bins.front().high));
  }
  return charts;
}

std::vector<ReportChart> ErrorCharts(std::span<const ConfigurationReport> configurations) {
  std::vector<ReportChart> charts;
  for (size_t error = 0; error < configurations[0].errors.size(); ++error) {
    const ErrorHistogram& first = configurations[0].errors[error];
    ReportChart& chart = charts.emplace_back();
    chart.id = fmt::format("error-{}", error);
    chart.title = fmt::format("Pose error: {}", first.title);
    int poses = 0;
    for (const ConfigurationReport& configuration : configurations)
      poses += configuration.errors[error].total;
    if (poses == 0) {
      chart.caption = "No pose was reported.";
      continue;
    }
    const std::string x_title = UnitTitle(first);
    chart.caption = CaptionOf(configurations, error);
    chart.table = CellsOf(configurations, error);
    chart.spec = (configurations.size() == 1 ? BarSpec(configurations[0].errors[error], x_title)
                                             : StepSpec(configurations, error, x_title))
                     .dump();
  }
  return charts;
}

}  // namespace pickbed::eval
