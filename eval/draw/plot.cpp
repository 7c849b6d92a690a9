#include "eval/draw/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "eval/page/ticks.h"

namespace pickbed::eval {
namespace {

constexpr int kLeft_px = 62, kRight_px = 16, kTop_px = 14, kBottom_px = 44;
constexpr double kTextSize = 0.42;
constexpr double kBandLightness = 0.75;
constexpr Rgb8 kPlotPaper{255, 255, 255}, kPlotInk{40, 40, 40}, kPlotGrid{225, 225, 225};
constexpr Rgb8 kMarked{232, 244, 234};

void Write(Canvas& canvas, const std::string& text, int x, int y) {
  canvas.Text(text, x, y, kPlotInk, kTextSize);
}

int WidthOf(const std::string& text) { return TextWidth(text, kTextSize); }

int Rounded(double px) { return static_cast<int>(std::lround(px)); }

Rgb8 Lightened(const Rgb8& color) {
  const auto channel = [](uint8_t value) {
    return static_cast<uint8_t>(std::lround(value + kBandLightness * (255 - value)));
  };
  return {channel(color.r), channel(color.g), channel(color.b)};
}

// Value at `at` of a polyline through (x, y) with ascending x.
double Between(const std::vector<Eigen::Vector2d>& line, double at) {
  for (size_t i = 1; i < line.size(); ++i) {
    if (at > line[i].x() && i + 1 < line.size()) continue;
    const double share = (at - line[i - 1].x()) / (line[i].x() - line[i - 1].x());
    return line[i - 1].y() + std::clamp(share, 0.0, 1.0) * (line[i].y() - line[i - 1].y());
  }
  return line.front().y();
}

// Both axes of a chart.
struct Axes {
  PlotAxis x, y;
  Eigen::Vector2d At(const Eigen::Vector2d& p) const { return {x.At(p.x()), y.At(p.y())}; }
};

Axes AxesOf(const Chart& chart, int width, int height, double y_min_top) {
  double x_min = 0, x_max = 1, y_max = y_min_top;
  bool first = true;
  for (const ChartSeries& series : chart.series) {
    for (const Eigen::Vector2d& p : series.points) {
      x_min = first ? p.x() : std::min(x_min, p.x());
      x_max = first ? p.x() : std::max(x_max, p.x());
      y_max = std::max(y_max, p.y());
      first = false;
    }
  }
  if (!(x_max > x_min)) x_max = x_min + 1;
  y_max = y_max > 0 ? 1.08 * y_max : 1;
  if (chart.percent) y_max = 1;
  return {PlotAxis(x_min, x_max, kLeft_px, width - kRight_px),
          PlotAxis(0, y_max, height - kBottom_px, kTop_px)};
}

// Shades between neighbouring points whose intervals are both known. A known interval without a
// known neighbor is a vertical line.
void DrawBand(Canvas& canvas, const Axes& axes, const ChartSeries& series) {
  for (size_t i = 0; i < series.band.size(); ++i) {
    if (!series.band[i].is_known()) continue;
    std::vector<Eigen::Vector2d> low, high;
    for (size_t k = i; k < std::min(i + 2, series.band.size()); ++k) {
      if (!series.band[k].is_known()) break;
      low.emplace_back(series.points[k].x(), series.band[k].low);
      high.emplace_back(series.points[k].x(), series.band[k].high);
    }
    const int last = Rounded(axes.x.At(low.back().x()));
    for (int x = Rounded(axes.x.At(low.front().x())); x <= last; ++x) {
      const double at = axes.x.ValueAt(x);
      const int top = Rounded(axes.y.At(Between(high, at)));
      const int bottom = Rounded(axes.y.At(Between(low, at)));
      canvas.Fill(x, top, 1, std::max(1, bottom - top), Lightened(series.color));
    }
  }
}

void DrawSeries(Canvas& canvas, const Axes& axes, const ChartSeries& series) {
  for (size_t i = 0; i < series.points.size(); ++i) {
    const Eigen::Vector2d here = axes.At(series.points[i]);
    if (series.dots)
      canvas.Dot(here, 4, series.color);
    else if (i > 0)
      canvas.Line(axes.At(series.points[i - 1]), here, series.color, 2);
  }
}

void DrawLegend(Canvas& canvas, const std::vector<ChartSeries>& all) {
  constexpr int kLine_px = 18;
  const int x = kLeft_px + 14;
  int y = kTop_px + 22;
  for (const ChartSeries& series : all) {
    if (series.name.empty()) continue;
    if (series.dots)
      canvas.Dot(Eigen::Vector2d(x + 10, y - 4), 4, series.color);
    else
      canvas.Line(Eigen::Vector2d(x, y - 4), Eigen::Vector2d(x + 20, y - 4), series.color, 2);
    Write(canvas, series.name, x + 28, y);
    y += kLine_px;
  }
}

}  // namespace

PlotAxis::PlotAxis(double min, double max, double first_px, double last_px)
    : min_(min), max_(max), first_px_(first_px), last_px_(last_px) {
  if (!(min < max)) throw std::logic_error("an axis of a plot has no extent");
}

double PlotAxis::At(double value) const {
  return first_px_ + (value - min_) / (max_ - min_) * (last_px_ - first_px_);
}

double PlotAxis::ValueAt(double at_px) const {
  return min_ + (at_px - first_px_) / (last_px_ - first_px_) * (max_ - min_);
}

void DrawXAxis(Canvas& canvas, const PlotAxis& axis, int top_px, int bottom_px,
               const std::string& label) {
  for (const double value : RoundTicks(axis.min(), axis.max())) {
    const int x = Rounded(axis.At(value));
    canvas.Line(Eigen::Vector2d(x, top_px), Eigen::Vector2d(x, bottom_px), kPlotGrid);
    const std::string text = fmt::format("{:.6g}", value);
    Write(canvas, text, x - WidthOf(text) / 2, bottom_px + 16);
  }
  const int center_px = Rounded(0.5 * (axis.At(axis.min()) + axis.At(axis.max())));
  Write(canvas, label, center_px - WidthOf(label) / 2, bottom_px + 36);
}

void DrawYAxis(Canvas& canvas, const PlotAxis& axis, int left_px, int right_px, bool percent) {
  for (const double value : RoundTicks(axis.min(), axis.max())) {
    const int y = Rounded(axis.At(value));
    canvas.Line(Eigen::Vector2d(left_px, y), Eigen::Vector2d(right_px, y), kPlotGrid);
    const std::string text = percent ? WholePercentText(value) : fmt::format("{:.6g}", value);
    Write(canvas, text, left_px - WidthOf(text) - 6, y + 4);
  }
}

Image<Rgb8> DrawChart(const Chart& chart, int width, int height, double y_min_top) {
  Canvas canvas(width, height, kPlotPaper);
  const Axes axes = AxesOf(chart, width, height, y_min_top);
  const int right = width - kRight_px, bottom = height - kBottom_px;
  if (chart.marked_x && chart.marked_x->high > chart.marked_x->low) {
    const int from = Rounded(axes.x.At(chart.marked_x->low));
    canvas.Fill(from, kTop_px, Rounded(axes.x.At(chart.marked_x->high)) - from, bottom - kTop_px,
                kMarked);
  }
  for (const ChartSeries& series : chart.series) DrawBand(canvas, axes, series);
  DrawXAxis(canvas, axes.x, kTop_px, bottom, chart.x_label);
  DrawYAxis(canvas, axes.y, kLeft_px, right, chart.percent);
  const Eigen::Vector2d origin(kLeft_px, bottom);
  canvas.Line(origin, Eigen::Vector2d(right, bottom), kPlotInk);
  canvas.Line(origin, Eigen::Vector2d(kLeft_px, kTop_px), kPlotInk);
  Write(canvas, chart.y_label, 4, kTop_px - 2);
  for (const ChartSeries& series : chart.series) DrawSeries(canvas, axes, series);
  DrawLegend(canvas, chart.series);
  return canvas.Take();
}

Image<Rgb8> DrawTable(const std::vector<std::string>& lines, int width, int height) {
  Canvas canvas(width, height, kPlotPaper);
  int y = 24;
  for (const std::string& line : lines) {
    const size_t tab = line.find('\t');
    Write(canvas, line.substr(0, tab), 10, y);
    if (tab != std::string::npos) Write(canvas, line.substr(tab + 1), 186, y);
    y += 21;
  }
  return canvas.Take();
}

Image<Rgb8> DrawDepthError(const Image<float>& ideal_m, const Image<float>& seen_m, double full_m) {
  Image<Rgb8> image(seen_m.width(), seen_m.height());
  for (size_t i = 0; i < image.size(); ++i) {
    if (!(seen_m.data()[i] > 0)) continue;
    const double share = (seen_m.data()[i] - ideal_m.data()[i]) / full_m;
    const auto rest = static_cast<uint8_t>(std::lround(255 * (1 - std::min(1.0, std::abs(share)))));
    image.data()[i] = share > 0 ? Rgb8{255, rest, rest} : Rgb8{rest, rest, 255};
  }
  return image;
}

}  // namespace pickbed::eval
