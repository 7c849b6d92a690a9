#include "eval/completion/draw.h"

#include <algorithm>
#include <cmath>

#include "eval/draw/canvas.h"
#include "eval/draw/overlay.h"

namespace pickbed::eval {
namespace {

constexpr int kTile_px = 112;
constexpr int kColumns = 3;  // of the sheet
constexpr Rgb8 kPaper{255, 255, 255};
constexpr Rgb8 kHidden{70, 70, 78};
constexpr Rgb8 kOccluder{200, 120, 40};
constexpr float kDrawnTruth = 0.5f;

uint8_t Byte(float share) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(share, 0.0f, 1.0f)));
}

// Depth of the segment in gray, near is bright; other pixels are dark, occluders orange.
Image<Rgb8> DrawSegment(const SegmentView& view, int size_px) {
  float near_m = 1e9f, far_m = 0;
  for (size_t i = 0; i < view.depth_m.size(); ++i) {
    if (!view.segment.pixels()[i]) continue;
    near_m = std::min(near_m, view.depth_m.pixels()[i]);
    far_m = std::max(far_m, view.depth_m.pixels()[i]);
  }
  Image<Rgb8> picture(size_px, size_px, kHidden);
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      const int column = x * view.depth_m.width() / size_px;
      const int row = y * view.depth_m.height() / size_px;
      if (view.segment(column, row)) {
        const float share = (view.depth_m(column, row) - near_m) / std::max(far_m - near_m, 1e-4f);
        const uint8_t gray = Byte(1 - 0.6f * share);
        picture(x, y) = {gray, gray, gray};
      } else if (!view.occluders.empty() && view.occluders(column, row)) {
        picture(x, y) = kOccluder;
      }
    }
  }
  return picture;
}

}  // namespace

CompletedVolume TrueVolume(const ViewedSolid& solid, const RandomView& drawn,
                           const CompletedVolume& cells) {
  CompletedVolume truth = cells;
  const Eigen::Isometry3f X_OC = drawn.X_CO.inverse().cast<float>();
  std::vector<Eigen::Vector3f> points_O;
  points_O.reserve(cells.occupancy.size());
  for (int z = 0; z < cells.size; ++z) {
    for (int y = 0; y < cells.size; ++y) {
      for (int x = 0; x < cells.size; ++x) points_O.push_back(X_OC * cells.Center_C(x, y, z));
    }
  }
  std::vector<uint8_t> inside(points_O.size());
  solid.Inside(points_O, inside);
  std::copy(inside.begin(), inside.end(), truth.occupancy.begin());
  return truth;
}

Image<Rgb8> DrawVolume(const CompletedVolume& volume, float level, bool from_side, int size_px) {
  Image<Rgb8> picture(size_px, size_px, kPaper);
  const CompletedVolume smooth = Smoothed(volume, 0.8f);
  const int n = volume.size;
  for (int y = 0; y < size_px; ++y) {
    for (int x = 0; x < size_px; ++x) {
      const int across = x * n / size_px, down = y * n / size_px;
      for (int depth = 0; depth < n; ++depth) {
        // From the side, the picture's x is the distance from the camera.
        const int cell[3] = {from_side ? n - 1 - depth : across, down, from_side ? across : depth};
        if (volume.occupancy[volume.Index(cell[0], cell[1], cell[2])] <= level) continue;
        const Eigen::Vector3f outward =
            -smooth.Gradient(volume.Center_C(cell[0], cell[1], cell[2]));
        const Eigen::Vector3f n_C = outward / std::max(outward.norm(), 1e-6f);
        const float facing = from_side ? n_C.x() : -n_C.z();
        const float light = 0.35f + 0.45f * std::max(facing, 0.0f) - 0.15f * n_C.y();
        const float near = 1 - 0.5f * static_cast<float>(depth) / static_cast<float>(n);
        picture(x, y) = {Byte(light * near * 0.85f), Byte(light * near),
                         Byte(light * near * 1.25f)};
        break;
      }
    }
  }
  return picture;
}

Image<Rgb8> DrawCompletions(const std::vector<CompletionTile>& tiles, float fixed_level) {
  std::vector<Image<Rgb8>> rows;
  std::vector<std::string> captions;
  for (const CompletionTile& tile : tiles) {
    Canvas canvas(5 * kTile_px + 8, kTile_px, kPaper);
    canvas.Paste(DrawSegment(tile.view, kTile_px), 0, 0);
    const float level = fixed_level > 0 ? fixed_level : perception::LevelForIou(tile.completed);
    canvas.Paste(DrawVolume(tile.completed, level, false, kTile_px), kTile_px + 2, 0);
    canvas.Paste(DrawVolume(tile.completed, level, true, kTile_px), 2 * kTile_px + 4, 0);
    canvas.Paste(DrawVolume(tile.truth, kDrawnTruth, false, kTile_px), 3 * kTile_px + 6, 0);
    canvas.Paste(DrawVolume(tile.truth, kDrawnTruth, true, kTile_px), 4 * kTile_px + 8, 0);
    rows.push_back(canvas.Take());
    captions.push_back(tile.caption);
  }
  if (rows.empty()) return {};
  return ContactSheet(rows, captions, kColumns);
}

}  // namespace pickbed::eval
