#include "eval/benchmark/rooms_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <string>

#include "eval/draw/overlay.h"
#include "eval/sweep/attempt_pictures.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

bool WriteRoomWithWrongPoses(const std::filesystem::path& folder, const ObjectSet& objects,
                             const LabelledView& view, const RoomEstimate& estimate,
                             double min_score) {
  AttemptScore score = estimate.image.score;
  KeepReported(min_score, score);
  const bool all_right = std::ranges::all_of(
      score.hypotheses, [](const ScoredHypothesis& pose) { return pose.recalled >= 0; });
  if (all_right) return false;
  const Image<Rgb8> picture = VisibleImage(view.frame);
  OverlayInput input{picture, view.frame.intrinsics, objects, OverlayPoses(score.hypotheses)};
  input.ids = &view.ids;
  input.missed = MissedInstances(score.instances);
  MakeFolder(folder);
  WritePng(folder / fmt::format("{:03}_{}_{}{}.png", estimate.image.trial, estimate.rooms,
                                estimate.background, estimate.fits_background ? "" : "_planes_off"),
           DrawOverlay(input));
  return true;
}

void RemoveRoomPictures(const std::filesystem::path& folder) {
  static const std::regex written("[0-9]{3,}_(bin|table|empty)_(given|fitted|unknown).*");
  for (const std::string& stem : StemsIn(folder, ".png")) {
    if (std::regex_match(stem, written)) std::filesystem::remove(folder / (stem + ".png"));
  }
}

}  // namespace pickbed::eval
