#include "eval/trial/instance_matcher.h"

#include <algorithm>

namespace pickbed::eval {

std::vector<TrueInstance> InstancesOf(const Scene& scene,
                                      const std::vector<double>& visible_fractions,
                                      const Pose& X_CW) {
  std::vector<TrueInstance> instances;
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    instances.push_back({posed.object, X_CW * posed.X_WO, visible_fractions[i], posed.instance});
  }
  return instances;
}

InstanceMatcher::InstanceMatcher(const std::vector<MetricModel>& models,
                                 std::vector<TrueInstance> instances)
    : models_(&models), instances_(std::move(instances)) {
  for (const MetricModel& model : models) means_O_.push_back(MeanVertex(model));
}

// The largest vertex displacement is at least the displacement of the mean vertex. Most instances
// never need the costly maximum over vertices and symmetries.
double InstanceMatcher::LowerBound_m(int position, const Pose& X_CO) const {
  const TrueInstance& instance = instances_[position];
  const Eigen::Vector3d& mean_O = means_O_[instance.object];
  const Eigen::Vector3d mean_C = X_CO * mean_O;
  double min_m = std::numeric_limits<double>::infinity();
  for (const Pose& S_O : model(instance.object).symmetries_O) {
    min_m = std::min(min_m, (mean_C - instance.X_CO * (S_O * mean_O)).norm());
  }
  return min_m;
}

// The nearest instance and all within `needed_m` are among the result.
std::vector<InstanceMatch> InstanceMatcher::Near(ObjectId object, const Pose& X_CO,
                                                 double needed_m) const {
  std::vector<std::pair<double, int>> bounds;  // m, position
  for (int i = 0; i < static_cast<int>(instances_.size()); ++i) {
    if (instances_[i].object == object) bounds.emplace_back(LowerBound_m(i, X_CO), i);
  }
  std::sort(bounds.begin(), bounds.end());
  std::vector<InstanceMatch> near;
  double min_m = std::numeric_limits<double>::infinity();
  for (const auto& [bound_m, position] : bounds) {
    if (bound_m > std::max(min_m, needed_m)) break;
    const double diameter_m = model(object).diameter_m;
    const double mssd_m = Mssd(model(object), X_CO, instances_[position].X_CO);
    near.push_back(
        {position, mssd_m, mssd_m / diameter_m, mssd_m < kCorrectDiameters * diameter_m});
    min_m = std::min(min_m, mssd_m);
  }
  std::stable_sort(near.begin(), near.end(), [](const InstanceMatch& a, const InstanceMatch& b) {
    return a.mssd_m < b.mssd_m;
  });
  return near;
}

std::vector<InstanceMatch> InstanceMatcher::ByDistance(ObjectId object, const Pose& X_CO) const {
  return Near(object, X_CO, kCorrectDiameters * model(object).diameter_m);
}

InstanceMatch InstanceMatcher::Nearest(ObjectId object, const Pose& X_CO) const {
  const std::vector<InstanceMatch> near = Near(object, X_CO, 0);
  return near.empty() ? InstanceMatch() : near.front();
}

bool InstanceMatcher::IsCorrectFor(int position, ObjectId object, const Pose& X_CO) const {
  if (instances_[position].object != object) return false;
  const double limit_m = kCorrectDiameters * model(object).diameter_m;
  return LowerBound_m(position, X_CO) < limit_m &&
         Mssd(model(object), X_CO, instances_[position].X_CO) < limit_m;
}

bool InstanceMatcher::IsCorrect(ObjectId object, const Pose& X_CO) const {
  for (int i = 0; i < static_cast<int>(instances_.size()); ++i) {
    if (IsCorrectFor(i, object, X_CO)) return true;
  }
  return false;
}

int InstanceMatcher::NearestOfAnyObject(ObjectId object, const Pose& X_CO) const {
  const Eigen::Vector3d mean_C = X_CO * means_O_[object];
  int nearest = -1;
  double min_m = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < instances_.size(); ++i) {
    const TrueInstance& instance = instances_[i];
    const double distance_m = (instance.X_CO * means_O_[instance.object] - mean_C).norm();
    if (distance_m >= min_m) continue;
    min_m = distance_m;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

int InstanceMatcher::NearestFree(ObjectId object, const Pose& X_CO, double max_distance_m,
                                 const std::vector<bool>& taken) const {
  const Eigen::Vector3d& mean_O = means_O_[object];
  double min_m = max_distance_m;
  int nearest = -1;
  for (size_t i = 0; i < instances_.size(); ++i) {
    if (taken[i] || instances_[i].object != object) continue;
    const double distance_m = (X_CO * mean_O - instances_[i].X_CO * mean_O).norm();
    if (distance_m >= min_m) continue;
    min_m = distance_m;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

int FirstFreeCorrect(const std::vector<InstanceMatch>& matches, const std::vector<bool>& taken) {
  for (const InstanceMatch& match : matches) {
    if (match.correct && !taken[match.position]) return match.position;
  }
  return -1;
}

}  // namespace pickbed::eval
