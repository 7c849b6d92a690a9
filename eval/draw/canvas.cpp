#include "eval/draw/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "eval/draw/opencv_image.h"

namespace pickbed::eval {
namespace {

constexpr int kShift = 4;        // sub-pixel bits of OpenCV's drawing
constexpr double kFar_px = 1e5;  // limit of coordinates, so that they fit an int
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

cv::Point SubPixel(const Eigen::Vector2d& p) {
  const auto channel = [](double v) {
    return static_cast<int>(std::lround(std::clamp(v, -kFar_px, kFar_px) * (1 << kShift)));
  };
  return {channel(p.x()), channel(p.y())};
}

// Whole OpenCV color map as a table. Calling OpenCV for each pixel takes seconds per picture.
std::array<Rgb8, 256> ColorTable(int map) {
  cv::Mat1b grey(1, 256);
  for (int i = 0; i < 256; ++i) grey(0, i) = static_cast<uint8_t>(i);
  cv::Mat3b bgr;
  cv::applyColorMap(grey, bgr, map);
  std::array<Rgb8, 256> table;
  for (int i = 0; i < 256; ++i) table[i] = {bgr(0, i)[2], bgr(0, i)[1], bgr(0, i)[0]};
  return table;
}

std::vector<cv::Point> SubPixels(const Polyline& points) {
  std::vector<cv::Point> fixed;
  for (const Eigen::Vector2d& p : points) fixed.push_back(SubPixel(p));
  return fixed;
}

Rgb8 ColorAt(const std::array<Rgb8, 256>& table, double share) {
  return table[std::lround(255 * std::clamp(share, 0.0, 1.0))];
}

}  // namespace

Rgb8 Mixed(const Rgb8& a, const Rgb8& b, double share) {
  const auto channel = [share](uint8_t p, uint8_t q) {
    return static_cast<uint8_t>(std::lround(p + share * (q - p)));
  };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

void Canvas::Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Rgb8 color, int width_px) {
  cv::Mat canvas = MatrixOf(image_);
  cv::line(canvas, SubPixel(a), SubPixel(b), ToScalar(color), width_px, cv::LINE_AA, kShift);
}

void Canvas::Curve(const Polyline& points, bool closed, Rgb8 color, int width_px) {
  cv::Mat canvas = MatrixOf(image_);
  cv::polylines(canvas, SubPixels(points), closed, ToScalar(color), width_px, cv::LINE_AA, kShift);
}

void Canvas::Polygon(const Polyline& corners, Rgb8 color) {
  cv::Mat canvas = MatrixOf(image_);
  cv::fillConvexPoly(canvas, SubPixels(corners), ToScalar(color), cv::LINE_AA, kShift);
}

void Canvas::Dot(const Eigen::Vector2d& center, double radius_px, Rgb8 color) {
  cv::Mat canvas = MatrixOf(image_);
  const int radius = static_cast<int>(std::lround(radius_px * (1 << kShift)));
  cv::circle(canvas, SubPixel(center), radius, ToScalar(color), cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::Ring(const Eigen::Vector2d& center, double radius_px, Rgb8 color, int width_px) {
  cv::Mat canvas = MatrixOf(image_);
  const int radius = static_cast<int>(std::lround(radius_px * (1 << kShift)));
  cv::circle(canvas, SubPixel(center), radius, ToScalar(color), width_px, cv::LINE_AA, kShift);
}

void Canvas::Frame(int x, int y, int width, int height, Rgb8 color, int width_px) {
  Fill(x, y, width, width_px, color);
  Fill(x, y + height - width_px, width, width_px, color);
  Fill(x, y, width_px, height, color);
  Fill(x + width - width_px, y, width_px, height, color);
}

void Canvas::Fill(int x, int y, int width, int height, Rgb8 color) {
  cv::Mat canvas = MatrixOf(image_);
  const cv::Rect all(0, 0, image_.width(), image_.height());
  canvas(cv::Rect(x, y, width, height) & all).setTo(ToScalar(color));
}

void Canvas::Shade(int x, int y, int width, int height, Rgb8 color, double opacity) {
  for (int v = std::max(0, y); v < std::min(image_.height(), y + height); ++v) {
    for (int u = std::max(0, x); u < std::min(image_.width(), x + width); ++u) {
      image_(u, v) = Mixed(image_(u, v), color, opacity);
    }
  }
}

void Canvas::Blend(Rgb8 color, const std::function<double(int x, int y)>& opacity) {
  for (int v = 0; v < image_.height(); ++v) {
    for (int u = 0; u < image_.width(); ++u) {
      image_(u, v) = Mixed(image_(u, v), color, opacity(u, v));
    }
  }
}

void Canvas::Text(const std::string& text, int x, int y, Rgb8 color, double size) {
  cv::Mat canvas = MatrixOf(image_);
  cv::putText(canvas, text, {x, y}, kFont, size, ToScalar(color), 1, cv::LINE_AA);
}

void Canvas::TextWithin(int width_px, const std::string& text, int x, int y, Rgb8 color,
                        double size) {
  const double share = static_cast<double>(width_px) / std::max(1, TextWidth(text, size));
  Text(text, x, y, color, size * std::min(1.0, share));
}

void Canvas::Label(const std::string& text, const Eigen::Vector2d& center, double size) {
  cv::Mat canvas = MatrixOf(image_);
  const int x = static_cast<int>(std::lround(center.x() - 0.5 * TextWidth(text, size)));
  const int y = static_cast<int>(std::lround(center.y() + 10 * size));
  cv::putText(canvas, text, {x, y}, kFont, size, cv::Scalar(20, 20, 20), 4, cv::LINE_AA);
  cv::putText(canvas, text, {x, y}, kFont, size, cv::Scalar(255, 255, 255), 1, cv::LINE_AA);
}

void Canvas::Paste(const Image<Rgb8>& tile, int x, int y) {
  cv::Mat canvas = MatrixOf(image_);
  const cv::Rect place =
      cv::Rect(x, y, tile.width(), tile.height()) & cv::Rect(0, 0, image_.width(), image_.height());
  if (place.empty()) return;
  MatrixOf(tile)(place - cv::Point(x, y)).copyTo(canvas(place));
}

int TextWidth(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, kFont, size, 1, &below).width;
}

std::vector<FlowPlace> FlowPlaces(const std::vector<int>& widths_px, int page_px, int margin_px,
                                  int gap_px) {
  std::vector<FlowPlace> places;
  int x = margin_px, line = 0;
  for (const int width_px : widths_px) {
    if (x > margin_px && x + width_px > page_px - margin_px) {
      x = margin_px;
      ++line;
    }
    places.push_back({x, line});
    x += width_px + gap_px;
  }
  return places;
}

Image<Rgb8> WithLegend(const Image<Rgb8>& picture, const std::vector<LegendEntry>& entries) {
  constexpr int kLine_px = 24, kSwatch_px = 14, kGap_px = 22, kMargin_px = 10;
  std::vector<int> widths_px;
  for (const LegendEntry& entry : entries) {
    widths_px.push_back(kSwatch_px + 6 + TextWidth(entry.meaning));
  }
  const std::vector<FlowPlace> places = FlowPlaces(widths_px, picture.width(), kMargin_px, kGap_px);
  const int lines = places.empty() ? 1 : places.back().line + 1;
  const int strip_px = lines * kLine_px + 8;
  Canvas canvas(picture.width(), picture.height() + strip_px, {250, 250, 250});
  canvas.Paste(picture, 0, 0);
  for (size_t i = 0; i < entries.size(); ++i) {
    const int y = picture.height() + 8 + places[i].line * kLine_px;
    canvas.Fill(places[i].x, y, kSwatch_px, kSwatch_px, {120, 120, 120});
    canvas.Fill(places[i].x + 1, y + 1, kSwatch_px - 2, kSwatch_px - 2, entries[i].color);
    canvas.Text(entries[i].meaning, places[i].x + kSwatch_px + 6, y + 12, {30, 30, 30});
  }
  return canvas.Take();
}

Image<Rgb8> SquareCrop(const Image<Rgb8>& image, const Eigen::Vector2d& center, double side_px,
                       int tile_px) {
  Image<Rgb8> tile(tile_px, tile_px);
  cv::Mat out = MatrixOf(tile);
  const double scale = tile_px / side_px;
  // Pixel centers: tile pixel t shows image pixel center + (t + 0.5 - tile / 2) / scale.
  const auto shift = [&](double c) { return 0.5 * tile_px - 0.5 - scale * c; };
  const cv::Matx23d to_tile(scale, 0, shift(center.x()), 0, scale, shift(center.y()));
  cv::warpAffine(MatrixOf(image), out, to_tile, out.size(), cv::INTER_LINEAR, cv::BORDER_CONSTANT,
                 cv::Scalar(250, 250, 250));
  return tile;
}

Image<Rgb8> Enlarged(const Image<Rgb8>& image, int factor, bool smooth) {
  Image<Rgb8> large(image.width() * factor, image.height() * factor);
  cv::Mat out = MatrixOf(large);
  cv::resize(MatrixOf(image), out, out.size(), 0, 0, smooth ? cv::INTER_CUBIC : cv::INTER_NEAREST);
  return large;
}

Image<Rgb8> Faded(const Image<Rgb8>& image) {
  constexpr double kColor = 0.2, kContrast = 0.62, kLift = 28;
  Image<Rgb8> faded(image.width(), image.height());
  for (size_t i = 0; i < image.size(); ++i) {
    const Rgb8 p = image.data()[i];
    const double luma = 0.299 * p.r + 0.587 * p.g + 0.114 * p.b;
    const auto channel = [luma](uint8_t v) {
      return static_cast<uint8_t>(kLift + kContrast * (kColor * v + (1 - kColor) * luma));
    };
    faded.data()[i] = {channel(p.r), channel(p.g), channel(p.b)};
  }
  return faded;
}

Rgb8 HeatColor(double share) {
  static const std::array<Rgb8, 256> table = ColorTable(cv::COLORMAP_HOT);
  return ColorAt(table, share);
}

Rgb8 TurboColor(double share) {
  static const std::array<Rgb8, 256> table = ColorTable(cv::COLORMAP_TURBO);
  return ColorAt(table, share);
}

Image<float> Smoothed(const Image<float>& image, double sigma_px) {
  Image<float> smooth(image.width(), image.height());
  const cv::Mat in(image.height(), image.width(), CV_32FC1, const_cast<float*>(image.data()));
  cv::Mat out(image.height(), image.width(), CV_32FC1, smooth.data());
  cv::GaussianBlur(in, out, cv::Size(), sigma_px, sigma_px, cv::BORDER_CONSTANT);
  return smooth;
}

}  // namespace pickbed::eval
