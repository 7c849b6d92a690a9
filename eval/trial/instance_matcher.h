#pragma once

// Matches poses with the true instances of one image.

#include <limits>
#include <vector>

#include "eval/metrics/pose_errors.h"
#include "scenes/base/ids.h"
#include "scenes/scene.h"

namespace pickbed::eval {

// Ground truth of one instance in the camera frame.
struct TrueInstance {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  double visible_fraction = 1;
  InstanceId instance = kNoInstance;
};

// Returns the instances in the order of scene.objects. `visible_fractions` are in the same order.
std::vector<TrueInstance> InstancesOf(const Scene& scene,
                                      const std::vector<double>& visible_fractions,
                                      const Pose& X_CW);

// An instance of the object of a pose, and its distance to the pose.
struct InstanceMatch {
  int position = -1;  // index of the instance; -1 = none
  double mssd_m = std::numeric_limits<double>::infinity();
  double mssd_diameters = std::numeric_limits<double>::infinity();
  bool correct = false;  // MSSD below kCorrectDiameters
};

class InstanceMatcher {
 public:
  // `models` are by object and must outlive this object.
  InstanceMatcher(const std::vector<MetricModel>& models, std::vector<TrueInstance> instances);

  const std::vector<TrueInstance>& instances() const { return instances_; }
  const MetricModel& model(ObjectId object) const { return models_->at(object); }

  // Returns instances of `object` by increasing MSSD to the pose. The nearest one and all for which
  // the pose is correct are among them.
  std::vector<InstanceMatch> ByDistance(ObjectId object, const Pose& X_CO) const;
  // Returns the nearest instance of `object`. Faster than ByDistance().
  InstanceMatch Nearest(ObjectId object, const Pose& X_CO) const;
  bool IsCorrectFor(int position, ObjectId object, const Pose& X_CO) const;
  // Returns whether the pose is correct for an instance.
  bool IsCorrect(ObjectId object, const Pose& X_CO) const;

  // Returns the instance of any object whose mean vertex is nearest to the mean vertex at the pose,
  // -1 if there is no instance.
  int NearestOfAnyObject(ObjectId object, const Pose& X_CO) const;
  // Returns the instance of `object` that is not `taken` and whose mean vertex is nearest, -1 if
  // none is within `max_distance_m`.
  int NearestFree(ObjectId object, const Pose& X_CO, double max_distance_m,
                  const std::vector<bool>& taken) const;

 private:
  double LowerBound_m(int position, const Pose& X_CO) const;
  std::vector<InstanceMatch> Near(ObjectId object, const Pose& X_CO, double needed_m) const;

  const std::vector<MetricModel>* models_;
  std::vector<Eigen::Vector3d> means_O_;  // mean vertices by object
  std::vector<TrueInstance> instances_;
};

// Returns the first match that is correct and not `taken`, -1 if there is none. `matches` are by
// distance.
int FirstFreeCorrect(const std::vector<InstanceMatch>& matches, const std::vector<bool>& taken);

}  // namespace pickbed::eval
