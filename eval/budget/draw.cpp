#include "eval/budget/draw.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "eval/draw/canvas.h"
#include "eval/draw/plot.h"

namespace pickbed::eval {
namespace {

constexpr Rgb8 kPaper{255, 255, 255}, kInk{35, 40, 48};
constexpr Rgb8 kAll{150, 158, 168}, kLeft{0, 138, 100}, kOther{90, 90, 90};
constexpr Rgb8 kFirst{0, 114, 178}, kSecond{213, 94, 0};
// Color-blind readers can distinguish these colors (Okabe and Ito 2008).
constexpr std::array<std::pair<const char*, Rgb8>, 8> kStages{{{"sense", {86, 180, 233}},
                                                               {"detect", {0, 114, 178}},
                                                               {"pose", {204, 121, 167}},
                                                               {"refine", {230, 159, 0}},
                                                               {"plan", {196, 178, 20}},
                                                               {"approach", {213, 94, 0}},
                                                               {"grasp", {126, 62, 152}},
                                                               {"simulate", {60, 60, 60}}}};
constexpr int kWidth = 900, kNames_px = 190, kRight_px = 40, kTop_px = 46, kBottom_px = 52;
constexpr int kLine_px = 30, kBar_px = 20;
constexpr int kValues_px = 300;  // width of the column with the numbers of the gains
constexpr double kText = 0.45, kTitle = 0.55;

Rgb8 ColorOf(const std::string& stage) {
  for (const auto& [name, color] : kStages) {
    if (stage == name) return color;
  }
  return kOther;
}

// Draws a bar from `from` to `to` percent, with its name and value.
void DrawBar(Canvas& canvas, const PlotAxis& axis, int line, const std::string& name, Rgb8 color,
             double from, double to, const std::string& value) {
  constexpr int kGap_px = 7, kMin_px = 3;
  const int y = kTop_px + line * kLine_px;
  canvas.Text(name, kNames_px - 12 - TextWidth(name, kText), y + kBar_px - 5, kInk, kText);
  const int right = static_cast<int>(std::lround(axis.At(to)));
  const int left = std::min(static_cast<int>(std::lround(axis.At(from))), right - kMin_px);
  canvas.Fill(left, y, right - left, kBar_px, color);
  const int width = TextWidth(value, kText);
  const bool fits_inside = right - left > width + 2 * kGap_px;
  const bool fits_before = left - width - kGap_px > kNames_px;
  const int x = fits_inside   ? left + kGap_px
                : fits_before ? left - width - kGap_px
                              : right + kGap_px;
  const bool dark = 0.299 * color.r + 0.587 * color.g + 0.114 * color.b < 150;
  canvas.Text(value, x, y + kBar_px - 5, fits_inside && dark ? kPaper : kInk, kText);
}

std::string ShareText(const WaterfallStep& step, int total) {
  const std::string share = PercentText(step.count, std::max(1, total));
  if (!step.ci95.is_known()) return fmt::format("{} = {}", step.count, share);
  return fmt::format("{} = {}  {}", step.count, share, IntervalText(step.ci95));
}

std::vector<LegendEntry> StagesOf(const std::vector<WaterfallStep>& steps) {
  std::vector<LegendEntry> legend;
  for (const auto& [name, color] : kStages) {
    const bool there = std::any_of(steps.begin(), steps.end(),
                                   [&](const WaterfallStep& step) { return step.group == name; });
    if (there) legend.push_back({color, name});
  }
  return legend;
}

// Axis range in percentage points: all intervals and zero, plus a margin of 5 %.
std::pair<double, double> RangeOf(const GainRows& gains) {
  double low = 0, high = 1;
  for (const GainRow& row : gains.rows) {
    for (const Gain& gain : {row.first, row.second}) {
      const bool known = gain.rise.is_known();
      low = std::min(low, known ? 100 * gain.rise.low : gain.points());
      high = std::max(high, known ? 100 * gain.rise.high : gain.points());
    }
  }
  const double margin = 0.05 * (high - low);
  return {low - margin, high + margin};
}

void DrawGain(Canvas& canvas, const PlotAxis& axis, const Gain& gain, double y, Rgb8 color) {
  constexpr double kCap_px = 4;
  canvas.Dot({axis.At(gain.points()), y}, 5, color);
  if (!gain.rise.is_known()) return;
  const double low = axis.At(100 * gain.rise.low), high = axis.At(100 * gain.rise.high);
  canvas.Line({low, y}, {high, y}, color, 2);
  for (const double end : {low, high}) {
    canvas.Line({end, y - kCap_px}, {end, y + kCap_px}, color, 2);
  }
}

}  // namespace

Image<Rgb8> DrawWaterfall(const Waterfall& waterfall) {
  const int lines = static_cast<int>(waterfall.steps.size()) + 2;
  const int bottom_px = kTop_px + lines * kLine_px;
  Canvas canvas(kWidth, bottom_px + kBottom_px, kPaper);
  canvas.Text(waterfall.title, 16, 26, kInk, kTitle);
  const PlotAxis axis(0, 100, kNames_px, kWidth - kRight_px);
  DrawXAxis(canvas, axis, kTop_px - 6, bottom_px,
            fmt::format("% of {}; {}", waterfall.whole,
                        waterfall.left.ci95.is_known() ? "brackets: 95 % over bins"
                                                       : "too few bins for an interval"));
  const double percent = 100.0 / std::max(1, waterfall.total);
  DrawBar(canvas, axis, 0, waterfall.all, kAll, 0, 100, fmt::format("{}", waterfall.total));
  int left = waterfall.total;
  int line = 1;
  for (const WaterfallStep& step : waterfall.steps) {
    const int before = left;
    left -= step.count;
    DrawBar(canvas, axis, line++, step.name, ColorOf(step.group), percent * left, percent * before,
            ShareText(step, waterfall.total));
  }
  DrawBar(canvas, axis, line, waterfall.left.name, kLeft, 0, percent * waterfall.left.count,
          ShareText(waterfall.left, waterfall.total));
  const std::vector<LegendEntry> legend = StagesOf(waterfall.steps);
  Image<Rgb8> picture = canvas.Take();
  return legend.empty() ? picture : WithLegend(picture, legend);
}

Image<Rgb8> DrawGains(const GainRows& gains) {
  constexpr int kRow_px = 46;
  const int bottom_px = kTop_px + static_cast<int>(gains.rows.size()) * kRow_px;
  Canvas canvas(kWidth, bottom_px + kBottom_px, kPaper);
  canvas.Text(gains.title, 16, 26, kInk, kTitle);
  const auto [low, high] = RangeOf(gains);
  const PlotAxis axis(low, high, kNames_px, kWidth - kValues_px);
  DrawXAxis(canvas, axis, kTop_px - 6, bottom_px, "gain, percentage points (bars: 95 % over bins)");
  canvas.Line({axis.At(0), kTop_px - 6}, {axis.At(0), bottom_px}, kInk);
  for (size_t i = 0; i < gains.rows.size(); ++i) {
    const GainRow& row = gains.rows[i];
    const int y = kTop_px + static_cast<int>(i) * kRow_px;
    canvas.Text(row.name, kNames_px - 12 - TextWidth(row.name, kText), y + 24, kInk, kText);
    DrawGain(canvas, axis, row.first, y + 11, kFirst);
    DrawGain(canvas, axis, row.second, y + 28, kSecond);
    const int x = kWidth - kValues_px + 40;
    canvas.Text(GainText(row.first), x, y + 16, kFirst, kText);
    canvas.Text(GainText(row.second), x, y + 33, kSecond, kText);
  }
  return WithLegend(canvas.Take(), {{kFirst, gains.first}, {kSecond, gains.second}});
}

}  // namespace pickbed::eval
