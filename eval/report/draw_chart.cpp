#include "eval/report/draw_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "eval/report/ticks.h"

namespace pickbed {
namespace {

constexpr int kLeft_px = 62, kRight_px = 16, kTop_px = 14, kBottom_px = 44;
constexpr double kTextSize = 0.42;
const cv::Scalar kInk(40, 40, 40), kGrid(225, 225, 225);

cv::Mat View(Image<Rgb8>& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, image.data());
}

cv::Scalar Ink(const Rgb8& color) { return cv::Scalar(color.r, color.g, color.b); }

void Write(cv::Mat& canvas, const std::string& text, cv::Point at, double size = kTextSize) {
  cv::putText(canvas, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
}

int WidthOf(const std::string& text) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kTextSize, 1, &below).width;
}

class Axes {
 public:
  Axes(const Chart& chart, int width, int height, double y_min_top)
      : width_(width), height_(height), y_max_(y_min_top) {
    bool first = true;
    for (const ChartSeries& series : chart.series) {
      for (const Eigen::Vector2d& p : series.points) {
        x_min_ = first ? p.x() : std::min(x_min_, p.x());
        x_max_ = first ? p.x() : std::max(x_max_, p.x());
        y_max_ = std::max(y_max_, p.y());
        first = false;
      }
    }
    if (!(x_max_ > x_min_)) x_max_ = x_min_ + 1;
    y_max_ = y_max_ > 0 ? 1.08 * y_max_ : 1;
  }

  cv::Point At(const Eigen::Vector2d& p) const {
    const double u = (p.x() - x_min_) / (x_max_ - x_min_), v = p.y() / y_max_;
    return {
        static_cast<int>(std::lround(kLeft_px + u * (width_ - kLeft_px - kRight_px))),
        static_cast<int>(std::lround(height_ - kBottom_px - v * (height_ - kTop_px - kBottom_px)))};
  }

  void Draw(cv::Mat& canvas, const Chart& chart) const {
    for (const double x : RoundTicks(x_min_, x_max_)) {
      cv::line(canvas, At({x, 0}), At({x, y_max_}), kGrid);
      const std::string text = fmt::format("{:.6g}", x);
      Write(canvas, text, At({x, 0}) + cv::Point(-WidthOf(text) / 2, 16));
    }
    for (const double y : RoundTicks(0, y_max_)) {
      cv::line(canvas, At({x_min_, y}), At({x_max_, y}), kGrid);
      const std::string text = fmt::format("{:.6g}", y);
      Write(canvas, text, At({x_min_, y}) + cv::Point(-WidthOf(text) - 6, 4));
    }
    cv::line(canvas, At({x_min_, 0}), At({x_max_, 0}), kInk);
    cv::line(canvas, At({x_min_, 0}), At({x_min_, y_max_}), kInk);
    Write(canvas, chart.x_label, {(width_ - WidthOf(chart.x_label)) / 2, height_ - 8});
    Write(canvas, chart.y_label, {4, kTop_px - 2});
  }

 private:
  int width_, height_;
  double x_min_ = 0, x_max_ = 1, y_max_ = 0;
};

void DrawSeries(cv::Mat& canvas, const Axes& axes, const ChartSeries& series) {
  for (size_t i = 0; i < series.points.size(); ++i) {
    const cv::Point here = axes.At(series.points[i]);
    if (series.dots)
      cv::circle(canvas, here, 4, Ink(series.color), cv::FILLED, cv::LINE_AA);
    else if (i > 0)
      cv::line(canvas, axes.At(series.points[i - 1]), here, Ink(series.color), 2, cv::LINE_AA);
  }
}

}  // namespace

Image<Rgb8> DrawChart(const Chart& chart, int width, int height, double y_min_top) {
  Image<Rgb8> image(width, height, {255, 255, 255});
  cv::Mat canvas = View(image);
  const Axes axes(chart, width, height, y_min_top);
  axes.Draw(canvas, chart);
  for (const ChartSeries& series : chart.series) DrawSeries(canvas, axes, series);
  int y = kTop_px + 22;
  for (const ChartSeries& series : chart.series) {
    if (series.name.empty()) continue;
    const int x = kLeft_px + 14;
    if (series.dots)
      cv::circle(canvas, {x + 10, y - 4}, 4, Ink(series.color), cv::FILLED, cv::LINE_AA);
    else
      cv::line(canvas, {x, y - 4}, {x + 20, y - 4}, Ink(series.color), 2, cv::LINE_AA);
    Write(canvas, series.name, {x + 28, y});
    y += 18;
  }
  return image;
}

Image<Rgb8> DrawTable(const std::vector<std::string>& lines, int width, int height) {
  Image<Rgb8> image(width, height, {255, 255, 255});
  cv::Mat canvas = View(image);
  int y = 24;
  for (const std::string& line : lines) {
    const size_t tab = line.find('\t');
    Write(canvas, line.substr(0, tab), {10, y});
    if (tab != std::string::npos) Write(canvas, line.substr(tab + 1), {186, y});
    y += 21;
  }
  return image;
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

}  // namespace pickbed
