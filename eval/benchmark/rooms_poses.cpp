#include "eval/benchmark/rooms_poses.h"

#include <fmt/format.h>

#include "eval/stats/statistics.h"
#include "perception/verify/image_domain.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

ResultColumns RoomPosesColumns() {
  return {{"image", "number of the image, from 0"},
          {"rooms", "kind of the room: bin, table or empty (no object)"},
          {"background", "given, fitted (planes were found) or unknown"},
          {"fits_background", "1 if planes were looked for"},
          {"object", "name of the object"},
          {"score", "score of the pose, at least 0.05", "0..1"},
          {"diameter_px", "diameter of the object in the image", "px"},
          {"right", "1 if the pose recalls an instance"}};
}

std::string RoomPosesLines(const ObjectSet& objects, const LabelledView& view,
                           const RoomEstimate& estimate) {
  std::string lines;
  for (const ScoredHypothesis& pose : estimate.image.score.hypotheses) {
    const ObjectModel& object = *objects[pose.estimate.object];
    const double diameter_px = perception::DiameterInImage_px(
        view.frame.intrinsics, object.diameter_m, pose.estimate.X_CO);
    lines += fmt::format("{},{},{},{},{},{:.4f},{:.1f},{}\n", estimate.image.trial, estimate.rooms,
                         estimate.background, int{estimate.fits_background}, CsvCell(object.name),
                         pose.record.score, diameter_px, int{pose.recalled >= 0});
  }
  return lines;
}

}  // namespace pickbed::eval
