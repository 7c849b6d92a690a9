#pragma once

// Scores of pose estimates, image by image, wherever image and truth come from: a BOP data set
// (eval/bop/evaluate.h) or bins that are filled on the spot (eval/comparison.h).

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/bop/results_csv.h"
#include "eval/bop/targets.h"
#include "eval/bop/vsd.h"
#include "scenes/object_model.h"

namespace pickbed {
struct ToleranceModel;  // grasp/tolerance.h
}

namespace pickbed::bop {

struct ObjectScores {
  int wanted = 0;  // instances to be found, BOP19
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;
  double adi_recall = 0;  // share found with ADI < 0.1 diameter
  // Mean chance over the instances to be found that a pick on the estimate that stands on it
  // (MSSD < 0.5 diameter) succeeds, 0 without one; nothing where the object has no tolerance model.
  std::optional<double> pick_chance = std::nullopt;
  bool detectable = false;  // has an instance that counts in BOP24
  double ap_mssd = 0, ap_mspd = 0;
};

struct Scores {
  double ar_vsd = 0, ar_mssd = 0, ar_mspd = 0;  // BOP19, over all instances
  double ap_mssd = 0, ap_mspd = 0;              // BOP24, mean over objects
  double adi_recall = 0;                        // of BOP19's instances, ADI < 0.1 diameter
  double ar() const { return (ar_vsd + ar_mssd + ar_mspd) / 3; }
  double ap() const { return (ap_mssd + ap_mspd) / 2; }
  int wanted = 0;                  // instances to be found, BOP19
  int images = 0;                  // with a target
  int estimates_elsewhere = 0;     // of images that are no target; they do not count
  double seconds_an_image = -1;    // -1 unless every estimate states its time
  std::vector<std::string> notes;  // what had to be made up, such as missing targets
  std::map<int, ObjectScores> objects;
};

struct TrueInstance {
  int object_id = 0;
  Pose X_CO = Pose::Identity();
  double visible_fraction = 0;
};

struct TrueImage {
  const CameraIntrinsics& intrinsics;
  const Image<float>& depth_m;  // as measured; 0 = no reading
  std::vector<TrueInstance> instances;
};

class Evaluator {
 public:
  // Asked once for each part, which is drawn and measured with all its vertices.
  using ModelOf = std::function<std::shared_ptr<const ObjectModel>(int object_id)>;
  // Null for an object without one.
  using ToleranceOf = std::function<const ToleranceModel*(int object_id)>;
  explicit Evaluator(ModelOf model_of, const VsdOptions& options = {},
                     ToleranceOf tolerance_of = {});
  ~Evaluator();

  void AddImage(const TrueImage& truth, const ImageTargets& targets,
                const std::vector<const Estimate*>& estimates);

  // Fills AR, AP, wanted, images and objects.
  void Finish(Scores& scores) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::bop
