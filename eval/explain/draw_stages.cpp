#include "eval/explain/draw_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/draw/bin_view.h"
#include "eval/draw/overlay.h"
#include "eval/draw/silhouettes.h"

namespace pickbed::eval {
namespace {

constexpr int kBoardWidth_px = 1280;
constexpr Rgb8 kNoReading{120, 60, 150};

}  // namespace

Board::Board(const RgbdFrame& frame, const ImageBox& shown)
    : region(shown),
      zoom(std::clamp(kBoardWidth_px / std::max(1, region.width), 1, 4)),
      camera(EnlargedBy(frame.intrinsics.Window(region.x, region.y, region.width, region.height),
                        zoom)),
      color(Enlarged(Cropped(VisibleImage(frame), region), zoom, true)),
      faded(Faded(color)) {}

Eigen::Vector2d Board::At(const Eigen::Vector2d& pixel) const {
  return ((pixel - Eigen::Vector2d(region.x, region.y)).array() + 0.5) * zoom - 0.5;
}

Image<Rgb8> DrawForeground(const RgbdFrame& frame, const OrganizedCloud& cloud) {
  Image<Rgb8> image = VisibleImage(frame);
  for (size_t i = 0; i < image.size(); ++i) {
    if (cloud.foreground.data()[i]) continue;
    const bool known = cloud.depth_m.data()[i] > 0;
    image.data()[i] = known ? Mixed(image.data()[i], {24, 30, 44}, 0.8) : kNoReading;
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
    heat.data()[i] = Mixed(Mixed(heat.data()[i], {0, 0, 0}, 0.45), HeatColor(0.08 + 0.92 * share),
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

Image<Rgb8> DrawPoses(const Board& board, const ObjectSet& objects,
                      const std::vector<DrawnPose>& poses, const std::vector<KeyEntry>& key) {
  std::vector<PlacedObject> placed;
  for (const DrawnPose& pose : poses) placed.push_back({pose.object, pose.X_CO});
  const std::vector<Silhouette> silhouettes = SilhouettesOf(placed, objects, board.camera);
  Canvas canvas(board.faded);
  for (size_t i = 0; i < poses.size(); ++i) {
    DrawCurves(canvas, silhouettes[i].curves, {poses[i].color, poses[i].style, 2, 1});
  }
  // Marks are drawn last, so that no outline covers them.
  for (size_t i = poses.size(); i-- > 0;) {
    if (poses[i].label.empty() || silhouettes[i].curves.empty()) continue;
    DrawPlate(canvas, {poses[i].mark, poses[i].label, 0.42}, silhouettes[i].inside);
  }
  return WithKey(canvas.Take(), key);
}

std::vector<KeyEntry> LineKey(const std::vector<LegendEntry>& legend) {
  std::vector<KeyEntry> key;
  for (const LegendEntry& entry : legend) {
    const LineStyle style = entry.color == kWrongColor ? LineStyle::kDashed : LineStyle::kSolid;
    key.push_back(
        {entry.meaning, KeyEntry::Sample::kLine, PoseMark::kUnknown, {entry.color, style, 2, 1}});
  }
  return key;
}

ImageBox ForegroundRegion(const OrganizedCloud& cloud) {
  constexpr double kMargin = 0.08;  // of the larger side
  const int width = cloud.foreground.width(), height = cloud.foreground.height();
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!cloud.foreground(x, y)) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  if (right < 0) return {0, 0, width, height};
  const int margin = static_cast<int>(kMargin * std::max(right - left, bottom - top)) + 1;
  left = std::max(0, left - margin);
  top = std::max(0, top - margin);
  return {left, top, std::min(width, right + margin + 1) - left,
          std::min(height, bottom + margin + 1) - top};
}

}  // namespace pickbed::eval
