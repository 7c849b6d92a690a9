#pragma once

// Accumulates scores of pose estimates over images. Images and ground truth come from a BOP data
// set (eval/bop/dataset_scores.h) or from simulated bins (eval/estimate/estimator_comparison.h).

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "eval/bop/scores.h"
#include "eval/bop/targets.h"
#include "eval/bop/vsd.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {
struct ToleranceModel;
}

namespace pickbed::eval {

struct ObjectScores {
  int wanted = 0;  // instances to be found, BOP19
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;
  double adi_recall = 0;  // share found with ADI < 0.1 diameter
  // Success probability of a pick on the estimate matched to an instance (MSSD < 0.5 diameter).
  // Mean over the instances to be found; an instance without a match counts as 0. nullopt without a
  // tolerance model of the object.
  std::optional<double> pick_chance = std::nullopt;
  bool detectable = false;  // has an instance that counts in BOP24
  double ap_mssd = 0, ap_mspd = 0;
  double ap_mssd_mm = 0;   // BOP25, thresholds in mm
  int never_reported = 0;  // as in DatasetScores
  int detect_wanted = 0;   // the same
};

struct DatasetScores {
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;  // BOP19, over all instances
  double ap_mssd = 0, ap_mspd = 0;              // BOP24, mean over objects; BOP25: ap_mssd
  double ap_mssd_mm = 0;                        // BOP25, thresholds in mm
  double adi_recall = 0;                        // share of BOP19's instances, ADI < 0.1 diameter
  double ar() const { return (ar_vsd + ar_mssd + ar_mspd) / 3; }
  double ap() const { return (ap_mssd + ap_mspd) / 2; }
  int wanted = 0;         // instances to be found, BOP19
  int images = 0;         // images with a target
  int detect_wanted = 0;  // instances that are at least 10 % visible, in BOP24's images
  // Instances among them without an estimate within half a diameter (MSSD), of any score.
  int never_reported = 0;
  std::vector<FloorRecall> floors;  // of BOP24's images, all estimates count
  int estimates_elsewhere = 0;      // estimates in images that are no target; they do not count
  // Estimates of objects without any instance in their image. As in the BOP toolkit, they do not
  // count in AP.
  int estimates_of_absent = 0;
  double seconds_an_image = -1;    // -1 unless every estimate states its time
  std::vector<std::string> notes;  // assumptions made, for example for missing targets files
  std::map<int, ObjectScores> objects;
};

struct ScoredInstance {
  int object_id = 0;
  Pose X_CO = Pose::Identity();
  double visible_fraction = 0;
};

struct ScoredImage {
  const CameraIntrinsics& intrinsics;
  const Image<float>& depth_m;  // as measured; 0 = no reading
  std::vector<ScoredInstance> instances;
};

// Computes VSD, MSSD, MSPD and ADI of all estimates of an image and accumulates recall and average
// precision. The rules are in eval/bop/scores.h. VSD renders the objects.
class ScoreAccumulator {
 public:
  // Called once per object. All errors use all vertices of the mesh.
  using ModelOf = std::function<std::shared_ptr<const ObjectModel>(int object_id)>;
  // Returns null for an object without a tolerance model.
  using ToleranceOf = std::function<const ToleranceModel*(int object_id)>;
  // `max_estimates`: of an image, in BOP24.
  explicit ScoreAccumulator(ModelOf model_of, const VsdOptions& options = {},
                            ToleranceOf tolerance_of = {},
                            int max_estimates = kMaxEstimatesOfImage);
  ~ScoreAccumulator();

  // Adds one image with all its estimates, of any object.
  void AddImage(const ScoredImage& truth, const ImageTargets& targets,
                const std::vector<const DatasetEstimate*>& estimates);

  // Fills all values of `scores` that do not depend on files.
  void Finish(DatasetScores& scores) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::eval
