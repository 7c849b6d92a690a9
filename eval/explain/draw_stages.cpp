#include "eval/explain/draw_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/draw/overlay.h"

namespace pickbed::eval::explain {
namespace {

constexpr int kBoardWidth_px = 1280;
constexpr Rgb8 kNoReading{120, 60, 150};

Rgb8 Blend(Rgb8 under, Rgb8 over, double share) {
  const auto channel = [share](uint8_t a, uint8_t b) {
    return static_cast<uint8_t>(std::lround((1 - share) * a + share * b));
  };
  return {channel(under.r, over.r), channel(under.g, over.g), channel(under.b, over.b)};
}

// Intrinsics of the enlarged image. Pixel centers have integer coordinates in both images.
CameraIntrinsics ZoomedBy(const CameraIntrinsics& k, int zoom) {
  return {k.width() * zoom, k.height() * zoom,           k.fx() * zoom,
          k.fy() * zoom,    (k.cx() + 0.5) * zoom - 0.5, (k.cy() + 0.5) * zoom - 0.5};
}

void DrawCross(Canvas& canvas, const Eigen::Vector2d& center, double half_px) {
  for (const auto& [color, width] : {std::pair{Rgb8{255, 255, 255}, 5}, std::pair{kWrong, 3}}) {
    for (const double side : {-1.0, 1.0}) {
      const Eigen::Vector2d arm(half_px, side * half_px);
      canvas.Line(center - arm, center + arm, color, width);
    }
  }
}

}  // namespace

Board::Board(const RgbdFrame& frame)
    : zoom(std::clamp(kBoardWidth_px / std::max(1, frame.intrinsics.width()), 1, 4)),
      camera(ZoomedBy(frame.intrinsics, zoom)),
      color(Enlarged(frame.color.empty() ? ColorizeDepth(frame.depth_m) : frame.color, zoom, true)),
      faded(Faded(color)) {}

Eigen::Vector2d Board::At(const Eigen::Vector2d& pixel) const {
  return ((pixel.array() + 0.5) * zoom - 0.5).matrix();
}

Image<Rgb8> DrawForeground(const RgbdFrame& frame, const OrganizedCloud& cloud) {
  Image<Rgb8> image = frame.color.empty() ? ColorizeDepth(frame.depth_m) : frame.color;
  for (size_t i = 0; i < image.size(); ++i) {
    if (cloud.foreground.data()[i]) continue;
    const bool known = cloud.depth_m.data()[i] > 0;
    image.data()[i] = known ? Blend(image.data()[i], {24, 30, 44}, 0.8) : kNoReading;
  }
  return image;
}

Image<Rgb8> DrawDots(const Board& board, const std::vector<ColoredDot>& dots, double radius_px,
                     const std::vector<LegendEntry>& legend) {
  Canvas canvas(board.faded);
  for (const ColoredDot& dot : dots) {
    canvas.Dot(board.At(dot.pixel), radius_px + 0.8, {20, 20, 20});
    canvas.Dot(board.At(dot.pixel), radius_px, dot.color);
  }
  return WithLegend(canvas.Take(), legend);
}

Image<Rgb8> DrawVoteMap(const Board& board, const std::vector<Eigen::Vector2d>& centers,
                        double sigma_px, const std::vector<ColoredDot>& rings,
                        const std::vector<LegendEntry>& legend) {
  Image<float> votes(board.camera.width(), board.camera.height());
  for (const Eigen::Vector2d& center : centers) {
    const Eigen::Vector2d at = board.At(center);
    const long x = std::lround(at.x()), y = std::lround(at.y());
    if (votes.Contains(static_cast<int>(x), static_cast<int>(y))) votes(x, y) += 1;
  }
  const double sigma = sigma_px * board.zoom;
  votes = Smoothed(votes, sigma);
  const float maximum = std::max(1e-9f, *std::ranges::max_element(votes.pixels()));
  Image<Rgb8> heat = board.faded;
  for (size_t i = 0; i < heat.size(); ++i) {
    // The square root makes the few votes of half-hidden instances visible beside the many others.
    const double share = std::sqrt(std::max(0.f, votes.data()[i]) / maximum);
    heat.data()[i] = Blend(Blend(heat.data()[i], {0, 0, 0}, 0.45), HeatColor(0.08 + 0.92 * share),
                           std::min(0.95, 1.6 * share));
  }
  Canvas canvas(std::move(heat));
  for (const ColoredDot& ring : rings) {
    canvas.Ring(board.At(ring.pixel), 9, {10, 10, 10}, 4);
    canvas.Ring(board.At(ring.pixel), 9, ring.color, 2);
  }
  std::vector<LegendEntry> all{
      {HeatColor(1),
       fmt::format("brightest: about {:.0f} votes within {:.1f} px (brightness is the square root)",
                   2 * std::numbers::pi * sigma * sigma * maximum, sigma_px)}};
  all.insert(all.end(), legend.begin(), legend.end());
  return WithLegend(canvas.Take(), all);
}

Image<Rgb8> DrawPoses(const Board& board, ObjectOutlines& outlines, const ObjectSet& objects,
                      const std::vector<DrawnPose>& poses, const std::vector<LegendEntry>& legend) {
  Canvas canvas(board.faded);
  for (auto pose = poses.rbegin(); pose != poses.rend(); ++pose) {
    const auto lines = outlines.At(pose->object, pose->X_CO, board.camera);
    for (const PixelLine& line : lines) canvas.Line(line.a, line.b, {20, 20, 20}, 3);
    for (const PixelLine& line : lines) canvas.Line(line.a, line.b, pose->color, 1);
  }
  // Marks are drawn last, so that no outline covers them.
  for (auto pose = poses.rbegin(); pose != poses.rend(); ++pose) {
    const Eigen::Vector3d center_C = pose->X_CO * objects[pose->object]->mass.com_O;
    if (!(center_C.z() > 0)) continue;
    const Eigen::Vector2d at = Project(board.camera, center_C);
    if (pose->crossed) DrawCross(canvas, at, 9);
    if (pose->label.empty()) continue;
    canvas.Label(pose->label, pose->crossed ? at + Eigen::Vector2d(0, 22) : at, 0.5);
  }
  return WithLegend(canvas.Take(), legend);
}

}  // namespace pickbed::eval::explain
