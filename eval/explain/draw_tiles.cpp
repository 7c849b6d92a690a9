#include "eval/explain/draw_tiles.h"

#include <algorithm>
#include <cmath>

namespace pickbed::eval {
namespace {

constexpr int kTile_px = 106, kGap_px = 8, kCaption_px = 17, kBlockGap_px = 26;
constexpr int kQueryColumns = 2, kFrame_px = 3;
constexpr int kPoseTile_px = 236, kPoseColumns = 5, kPoseCaption_px = 40;
constexpr Rgb8 kPaper{250, 250, 250}, kInk{30, 34, 40}, kFaint{110, 118, 128};

// A square crop of the image, scaled to a tile, with the matching camera.
struct Cutout {
  Cutout(const Board& board, const Eigen::Vector2d& center, double side_px, int tile_px)
      : image(SquareCrop(board.color, center, side_px, tile_px)) {
    const CameraIntrinsics& k = board.camera;
    const double scale = tile_px / side_px, center_px = 0.5 * (tile_px - 1);
    camera = {tile_px,
              tile_px,
              scale * k.fx(),
              scale * k.fy(),
              scale * (k.cx() - center.x()) + center_px,
              scale * (k.cy() - center.y()) + center_px};
  }
  Image<Rgb8> image;
  CameraIntrinsics camera;
};

void DrawOutline(Canvas& canvas, const std::vector<PixelLine>& lines, Rgb8 color) {
  for (const PixelLine& line : lines) canvas.Line(line.a, line.b, {15, 15, 15}, 3);
  for (const PixelLine& line : lines) canvas.Line(line.a, line.b, color, 1);
}

Image<Rgb8> PlaceTile(const Board& board, const QueryTile& query) {
  Canvas tile(Cutout(board, board.At(query.pixel), query.view_px * board.zoom, kTile_px).image);
  const int side = static_cast<int>(std::lround(kTile_px * query.side_px / query.view_px));
  const int corner = (kTile_px - side) / 2;
  tile.Frame(corner - 1, corner - 1, side + 2, side + 2, {20, 20, 20}, 3);
  tile.Frame(corner, corner, side, side, kUnknownColor, 1);
  return tile.Take();
}

Image<Rgb8> VoteTile(const Board& board, ObjectOutlines& outlines, const QueryTile& query,
                     const NeighborTile& neighbor) {
  const Cutout cutout(board, board.At(query.pixel), query.view_px * board.zoom, kTile_px);
  Canvas tile(cutout.image);
  DrawOutline(tile, outlines.At(neighbor.object, neighbor.X_CO, cutout.camera), neighbor.color);
  return tile.Take();
}

Image<Rgb8> FramedPatch(const std::optional<PatchValues>& values, PatchChannels channels,
                        Rgb8 frame) {
  Canvas tile(kTile_px, kTile_px, frame);
  static_assert(kTile_px - 2 * kFrame_px >= 3 * kPatchPixels);
  tile.Fill(kFrame_px, kFrame_px, kTile_px - 2 * kFrame_px, kTile_px - 2 * kFrame_px,
            {225, 228, 232});
  if (values) {
    constexpr int kAt = (kTile_px - 3 * kPatchPixels) / 2;
    tile.Paste(Enlarged(PatchPicture(*values, channels), 3, false), kAt, kAt);
  } else {
    tile.Text("no view", 24, kTile_px / 2 + 4, kFaint, 0.42);
  }
  return tile.Take();
}

int BlockWidth(size_t neighbors) {
  return static_cast<int>(neighbors + 1) * (kTile_px + kGap_px) + kGap_px;
}
constexpr int kBlockHeight_px = kCaption_px + 2 * kTile_px + kGap_px;

void DrawQuery(Canvas& sheet, int x, int y, const Board& board, ObjectOutlines& outlines,
               const QueryTile& query, PatchChannels channels) {
  const int patch_y = y + kCaption_px, place_y = patch_y + kTile_px + kGap_px / 2;
  sheet.Text("query", x, y + 12, kInk, 0.42);
  sheet.Paste(FramedPatch(query.patch->values, channels, kUnknownColor), x, patch_y);
  sheet.Paste(PlaceTile(board, query), x, place_y);
  for (const NeighborTile& neighbor : query.neighbors) {
    x += kTile_px + kGap_px;
    sheet.TextWithin(kTile_px, neighbor.caption, x, y + 12, kInk, 0.38);
    sheet.Paste(FramedPatch(neighbor.patch, channels, neighbor.color), x, patch_y);
    sheet.Paste(VoteTile(board, outlines, query, neighbor), x, place_y);
  }
}

Image<Rgb8> PoseCrop(const Board& board, ObjectOutlines& outlines, const ObjectModel& object,
                     const ModelPoints& model, const PoseTile& pose) {
  constexpr double kViewDiameters = 1.3;
  const Eigen::Vector3d center_C = pose.X_CO * model.center_O.cast<double>();
  const Eigen::Vector2d center = Project(board.camera, center_C);
  const double side_px = kViewDiameters * object.diameter_m * board.camera.fx() / center_C.z();
  Cutout cutout(board, center, side_px, kPoseTile_px);
  Canvas tile(Faded(cutout.image));
  for (const PixelLine& line : outlines.At(pose.object, pose.X_CO, cutout.camera)) {
    tile.Line(line.a, line.b, {255, 255, 255});
  }
  // Points that contradict the pose are drawn last, so that they remain visible.
  for (const PointFit fit : {PointFit::kUnknown, PointFit::kHidden, PointFit::kAgrees,
                             PointFit::kWrongNormal, PointFit::kViolates}) {
    for (const JudgedPoint& point : pose.points) {
      if (point.fit != fit) continue;
      const Eigen::Vector3d p_C = pose.X_CO * model.points_O[point.point].cast<double>();
      tile.Dot(Project(cutout.camera, p_C), 1.7, FitColor(fit));
    }
  }
  tile.Frame(0, 0, kPoseTile_px, kPoseTile_px, pose.color, kFrame_px);
  return tile.Take();
}

}  // namespace

Image<Rgb8> PatchPicture(const PatchValues& values, PatchChannels channels) {
  const Eigen::Vector3d light = Eigen::Vector3d(-0.45, -0.55, -0.7).normalized();
  Image<Rgb8> picture(kPatchPixels, kPatchPixels);
  for (int i = 0; i < kPatchArea; ++i) {
    if (channels == PatchChannels::kDepthColor && !IsUnknownAt(values, i)) {
      picture.data()[i] = PatchColorAt(values, i);
      continue;
    }
    const double depth = values[i] / 127.0;
    const Eigen::Vector3d normal =
        Eigen::Vector3d(values[kPatchArea + i], values[2 * kPatchArea + i],
                        values[3 * kPatchArea + i]) /
        127;
    const bool has_normal = normal.squaredNorm() > 0.1;
    if (!has_normal && values[i] == 127) {
      picture.data()[i] = {38, 42, 50};
      continue;
    }
    const double shade = has_normal ? 0.35 + 0.65 * std::max(0.0, normal.dot(light)) : 0.6;
    // Uses only the center of the Turbo color map, because its ends are dark.
    const Rgb8 hue = TurboColor(0.12 + 0.76 * 0.5 * (1 - depth));
    const auto channel = [shade](uint8_t v) { return static_cast<uint8_t>(shade * v); };
    picture.data()[i] = {channel(hue.r), channel(hue.g), channel(hue.b)};
  }
  return picture;
}

Image<Rgb8> PatchSheet(const Board& board, ObjectOutlines& outlines,
                       const std::vector<QueryTile>& queries, PatchChannels channels,
                       const std::vector<LegendEntry>& legend) {
  size_t maximum = 0;
  for (const QueryTile& query : queries) maximum = std::max(maximum, query.neighbors.size());
  const int block = BlockWidth(maximum);
  const int rows = (static_cast<int>(queries.size()) + kQueryColumns - 1) / kQueryColumns;
  Canvas sheet(kQueryColumns * block + kBlockGap_px, rows * (kBlockHeight_px + kGap_px) + kGap_px,
               kPaper);
  for (size_t i = 0; i < queries.size(); ++i) {
    const int column = static_cast<int>(i) % kQueryColumns,
              row = static_cast<int>(i) / kQueryColumns;
    DrawQuery(sheet, kGap_px + column * (block + kBlockGap_px - kGap_px),
              kGap_px + row * (kBlockHeight_px + kGap_px), board, outlines, queries[i], channels);
  }
  return WithLegend(sheet.Take(), legend);
}

Rgb8 FitColor(PointFit fit) {
  switch (fit) {
    case PointFit::kAgrees:
      return kRightColor;
    case PointFit::kWrongNormal:
      return {255, 236, 120};
    case PointFit::kHidden:
      return {40, 46, 58};
    case PointFit::kViolates:
      return kWrongColor;
    case PointFit::kUnknown:
      break;
  }
  return {200, 200, 205};
}

std::vector<LegendEntry> FitLegend() {
  return {{FitColor(PointFit::kAgrees), "agrees: measured where the model is"},
          {FitColor(PointFit::kWrongNormal), "measured there, but the surface normal differs"},
          {FitColor(PointFit::kHidden), "hidden behind something nearer"},
          {FitColor(PointFit::kViolates), "violates: the camera measured a surface behind it"},
          {FitColor(PointFit::kUnknown), "unknown: no reading, or background there"}};
}

Image<Rgb8> PoseGallery(const Board& board, ObjectOutlines& outlines, const ObjectSet& objects,
                        const std::vector<ModelPoints>& models,
                        const std::vector<PoseTile>& tiles) {
  const int count = static_cast<int>(tiles.size());
  const int rows = (count + kPoseColumns - 1) / kPoseColumns;
  const int pitch_y = kPoseTile_px + kPoseCaption_px + kGap_px;
  Canvas sheet(kPoseColumns * (kPoseTile_px + kGap_px) + kGap_px, rows * pitch_y + kGap_px, kPaper);
  for (int i = 0; i < count; ++i) {
    const PoseTile& pose = tiles[i];
    const int x = kGap_px + i % kPoseColumns * (kPoseTile_px + kGap_px);
    const int y = kGap_px + i / kPoseColumns * pitch_y;
    sheet.TextWithin(kPoseTile_px - 2, pose.title, x + 2, y + 15, kInk, 0.46);
    sheet.TextWithin(kPoseTile_px - 2, pose.caption, x + 2, y + 33, kFaint, 0.4);
    sheet.Paste(PoseCrop(board, outlines, *objects[pose.object], models[pose.object], pose), x,
                y + kPoseCaption_px);
  }
  return WithLegend(sheet.Take(), FitLegend());
}

}  // namespace pickbed::eval
