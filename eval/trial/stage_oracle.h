#pragma once

// Stage oracles: ground truth substituted for single stages of an attempt. They measure how much a
// perfect stage would gain. The other stages keep their errors.
//
// A hypothesis matches an instance of its own object if their mean vertices are less than half a
// diameter apart. In order of falling score, each takes the nearest instance that is still free.
//
// - sense: every instance that is not a distractor counts as visible. Without `sense`, its visible
//   fraction must be at least kCountedVisibility. The stages below use only visible instances.
// - detection: hypotheses that match no visible instance are removed. Each visible instance without
//   a hypothesis gets one with the true pose, because the pose that the estimator would have found
//   is unknown. The gain is therefore an upper bound for better detection.
// - pose: a hypothesis that matches an instance gets its true pose as the start of the scenario's
//   refiner. The oracle estimator has no refiner. Suppressed poses are removed. A hypothesis that
//   matches no instance stays wrong.
// - refinement: a hypothesis gets the true pose of an instance if it was correct for it before or
//   after refinement, or if it suppressed a correct pose. Other hypotheses do not change.
// - grasp: grasps are tried in the true scene until one succeeds. First come the planner's best
//   grasps, then the best that it rejects for tilt, quality, clearance or observed obstacles. If
//   none succeeds, the planner's first grasp is kept.
// With sense, detection, pose and refinement, the estimator does not run, and the camera has no
// errors of its focal length, principal point and depth. In the other reruns, a true pose is the
// one that is seen in the image with these errors.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "eval/trial/instance_matcher.h"
#include "perception/pose_hypothesis.h"
#include "scenes/base/ids.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// MSSD, or distance of the mean vertices, within which a pose matches an instance, however wrong it
// is.
inline constexpr double kMatchDiameters = 0.5;

// Stages with ground truth substituted.
struct OracleStages {
  bool sense = false;
  bool detection = false;
  bool pose = false;
  bool refinement = false;
  bool grasp = false;

  bool operator==(const OracleStages&) const = default;
  bool AllOfPerception() const { return sense && detection && pose && refinement; }
};

// A named oracle rerun and the stages that it substitutes.
struct OracleRow {
  const char* name;
  const char* help;
  OracleStages truth;
};
// Returns all oracle reruns, in the order of the help.
std::span<const OracleRow> OracleTable();
// Returns the row with this name. Throws InputError with the known names if there is none.
const OracleRow& OracleNamed(const std::string& name);

// Applies detection, pose and refinement as above, in this order. `visible` has the visible
// instances. The score of a new hypothesis is 0.5 + 0.5 * visible fraction, because its position is
// certain. Returns the hypotheses in order of falling score.
std::vector<PoseHypothesis> SubstituteTruth(std::vector<PoseHypothesis> estimated,
                                            const InstanceMatcher& visible,
                                            const OracleStages& truth);

// The final refinement of a scenario without its estimator, for substituted poses.
class OracleRefiner {
 public:
  // `refiner` is a row of RefinerTable(). Throws InputError for another name.
  OracleRefiner(const ObjectSet& objects, const std::string& refiner);
  ~OracleRefiner();
  // Refines the poses of `hypotheses` in place.
  void Refine(const RgbdFrame& frame, const KnownBackground& background,
              std::vector<PoseHypothesis>& hypotheses) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::eval
