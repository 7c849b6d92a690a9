#pragma once

// Pictures of picks of unknown objects: what the planner saw and completed, and its grasp.

#include <string>
#include <utility>
#include <vector>

#include "eval/report/completed_shapes.h"
#include "eval/trial/observer.h"

namespace pickbed::eval {

// Picture of one pick.
struct GraspTile {
  std::string caption;  // result and score
  bool succeeded = false;
  Image<Rgb8> picture;
};

// Returns the shape with the cell over kSurfaceLevel that is nearest to a grasp. Null without such
// a cell.
const grasp::OccupancyShape* GraspedShape(const std::vector<grasp::OccupancyShape>& shapes,
                                          const Grasp& grasp);

// Draws the first picks of a planner: one that succeeded and some that failed. From left to right
// these are the segments of the image, the completed shape at the grasp from the camera and from
// its side, and the hand at the grasp. A planner that completes no shapes has only the
// last picture.
class GraspPictures : public TrialObserver {
 public:
  static constexpr int kMaxSucceeded = 1, kMaxFailed = 2;

  // `spec` must outlive this object. Throws InputError for an unknown segmentation or completion.
  explicit GraspPictures(const ScenarioSpec& spec) : spec_(spec), shapes_(spec) {}

  void OnStage(TrialStage stage, const AttemptState& attempt) override;
  // Returns the pictures so far, and forgets them.
  std::vector<GraspTile> TakeTiles() { return std::move(tiles_); }

 private:
  Image<Rgb8> Draw(const AttemptState& attempt) const;

  const ScenarioSpec& spec_;
  CompletedShapes shapes_;
  Scene before_;  // the scene before the pick
  int succeeded_ = 0, failed_ = 0;
  std::vector<GraspTile> tiles_;
};

}  // namespace pickbed::eval
