#include "eval/summary/occlusion_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/draw/marks.h"
#include "eval/draw/silhouettes.h"
#include "eval/stats/statistics.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

constexpr int kTile_px = 240, kGap_px = 6, kCaption_px = 20, kHead_px = 3 * kCaption_px;
constexpr double kSideDiameters = 2.2;  // side of a tile, in diameters of the target
constexpr Rgb8 kPaper{250, 250, 250}, kInk{20, 20, 20};

Image<Rgb8> ViewOfTarget(const AttemptState& attempt, size_t index, const sim::Picture& picture) {
  Canvas canvas(picture.color);
  const PosedObject& target = attempt.scene.objects[index];
  const auto id = static_cast<uint16_t>(target.instance + 1);
  DrawCurves(canvas, SilhouetteOf(picture.ids, id, 1).curves, {kTargetColor});
  const ObjectModel& model = *attempt.cell.objects()[target.object];
  const Camera& camera = picture.camera;
  const Eigen::Vector3d center_C = camera.X_CW() * (target.X_WO * model.mass.com_O);
  const double side_px = kSideDiameters * model.diameter_m * camera.intrinsics.fx() / center_C.z();
  return SquareCrop(canvas.Take(), Project(camera.intrinsics, center_C), side_px, kTile_px);
}

// "12 of 20: 60.0 % [38.7, 78.1]"; without an interval if there are too few bins.
std::string RateOfBand(const ShareOfAttempts& share, const BandStatistics& band) {
  return fmt::format("{} of {}: {}", share.hits, band.attempts,
                     ShortRateText({share.hits, band.attempts, share.ci95}));
}

}  // namespace

std::string BandTileName(int band) { return fmt::format("band_{}.png", band); }

Image<Rgb8> BandTile(const AttemptState& attempt, const sim::Picture& picture) {
  const std::vector<PosedObject>& objects = attempt.scene.objects;
  const auto target = std::find_if(objects.begin(), objects.end(), [&](const PosedObject& posed) {
    return posed.instance == attempt.record.target;
  });
  const size_t index = target - objects.begin();
  Canvas canvas(kTile_px, kTile_px + kCaption_px, kPaper);
  canvas.Text(fmt::format("{} visible, {} instances",
                          PercentText(attempt.view->visible_fractions[index]), objects.size()),
              2, kCaption_px - 5, kInk, 0.4);
  canvas.Paste(ViewOfTarget(attempt, index, picture), 0, kCaption_px);
  return canvas.Take();
}

void WriteSeriesSheet(const std::filesystem::path& sheet,
                      const std::vector<BandStatistics>& bands) {
  const std::filesystem::path pictures = sheet.parent_path();
  std::vector<std::filesystem::path> rows;  // trial folders
  if (!std::filesystem::is_directory(pictures)) return;
  const int columns = static_cast<int>(bands.size());
  for (const auto& entry : std::filesystem::directory_iterator(pictures)) {
    for (int band = 0; band < columns; ++band) {
      if (!std::filesystem::exists(entry.path() / BandTileName(band))) continue;
      rows.push_back(entry.path());
      break;
    }
  }
  if (rows.empty()) return;
  std::sort(rows.begin(), rows.end());
  constexpr int kAcross_px = kTile_px + kGap_px, kDown_px = kTile_px + kCaption_px + kGap_px;
  Canvas canvas(columns * kAcross_px + kGap_px, kHead_px + static_cast<int>(rows.size()) * kDown_px,
                kPaper);
  for (int band = 0; band < columns; ++band) {
    const int x = kGap_px + band * kAcross_px;
    canvas.Text(bands[band].band.name() + " % visible", x + 2, kCaption_px - 5, kInk, 0.5);
    canvas.TextWithin(kTile_px - 4, "found " + RateOfBand(bands[band].recalled, bands[band]), x + 2,
                      2 * kCaption_px - 5, kInk, 0.4);
    canvas.TextWithin(kTile_px - 4, "picked " + RateOfBand(bands[band].picked, bands[band]), x + 2,
                      3 * kCaption_px - 5, kInk, 0.4);
    for (size_t row = 0; row < rows.size(); ++row) {
      const std::filesystem::path file = rows[row] / BandTileName(band);
      if (!std::filesystem::exists(file)) continue;
      canvas.Paste(ReadPng(file), x, kHead_px + static_cast<int>(row) * kDown_px);
    }
  }
  WritePng(sheet, canvas.Take());
}

}  // namespace pickbed::eval
