#pragma once

// Truth in place of stages of a pick, for the question what perfecting a stage would gain. The
// stages that are left keep what they got wrong.
//
// A hypothesis stands on a part when it is of the part's kind and their mean vertices are less than
// half a diameter apart; in falling order of score each takes the nearest part that is still free.
//
// - sense: every wanted part counts as in view, however much of it is hidden. Only parts in view
//   are fed by the stages below; without `sense` those at least kCountedVisibility visible.
// - detection: hypotheses that stand on no part in view are dropped, and each part in view without
//   one gets one. The new one has the true pose: what pose the estimator would have found
//   there nobody knows, so the gain is the most that better detection can bring.
// - pose: a hypothesis that stands on a part gets its true pose, as the start of the scenario's
//   refiner (none for the oracle estimator, which does not refine); what was suppressed is
//   forgotten. One that stands on none stays wrong.
// - refinement: a hypothesis that was right before refinement, is right after it, or made a right
//   one give way gets the true pose of the part that it is right for. One that was never right
//   stays as it was.
// - grasp: the planner's best grasps, then the best of what it rejects for tilt, quality or what it
//   sees are tried in the true scene until one succeeds; where none does, the planner's first
//   stays.
// With sense, detection, pose and refinement fed, the estimator is not asked.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "eval/metrics.h"
#include "perception/pose_hypothesis.h"
#include "scenes/bin.h"
#include "scenes/rgbd_frame.h"

namespace pickbed {

struct TruthStages {
  bool sense = false;
  bool detection = false;
  bool pose = false;
  bool refinement = false;
  bool grasp = false;

  bool operator==(const TruthStages&) const = default;
  bool AllOfPerception() const { return sense && detection && pose && refinement; }
};

// What a rerun feeds.
struct OracleRow {
  const char* name;
  const char* help;
  TruthStages truth;
};
std::span<const OracleRow> OracleTable();
// Throws InputError with the known names.
const OracleRow& OracleNamed(const std::string& name);

// A part as it truly stands.
struct FedPart {
  int object = 0;
  Pose X_CO = Pose::Identity();
  double visible_fraction = 1;
};

// detection, pose and refinement as above, in this order; `parts` are those in view. The score of a
// new hypothesis is 0.5 for a hidden part to 1 for one that is all in view: its place is sure.
// Result sorted by falling score.
std::vector<PoseHypothesis> WithTruth(std::vector<PoseHypothesis> believed,
                                      const std::vector<FedPart>& parts,
                                      const std::vector<MetricModel>& models,
                                      const TruthStages& truth);

// The refiner of a scenario alone, for poses that were fed.
class FedRefiner {
 public:
  // `refiner` is a row of RefinerNames() in scenes/scenario_spec.h.
  FedRefiner(const ObjectSet& objects, const std::string& refiner);
  ~FedRefiner();
  void Refine(const RgbdFrame& frame, const KnownBackground& background,
              std::vector<PoseHypothesis>& hypotheses) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
