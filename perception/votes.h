#pragma once

// From thousands of raw poses to some hundreds of different ones.

#include <Eigen/Core>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

struct RawHypothesis {
  int object = 0;
  Pose X_CO = Pose::Identity();
  float quick_score = 0;  // QuickScore, higher is better
  float votes = 1;        // raw hypotheses that agree with it
};

// Distance of two poses of one part: largest displacement over eight key points (corners of the
// bounding box; points on the axis for a continuous symmetry), least over the discrete symmetries,
// over the diameter.
class PoseDistance {
 public:
  explicit PoseDistance(const ObjectModel& model);
  double operator()(const Pose& X_CA, const Pose& X_CB) const;

  double diameter_m() const { return diameter_m_; }
  int keypoints() const { return static_cast<int>(keypoints_O_.size()); }
  // Key points under each symmetry in turn, identity first: keypoints() of them a symmetry.
  const std::vector<Eigen::Vector3d>& symmetric_keypoints_O() const { return variants_O_; }

 private:
  std::vector<Eigen::Vector3d> keypoints_O_;
  std::vector<Eigen::Vector3d> variants_O_;
  double diameter_m_ = 0;
};

// Greedy, best quick score first (of equals the earlier): a hypothesis within `radius` (share of
// diameter) of a kept one is merged into the best such and its votes are added; at most `max_kept`
// are returned, best first. `distances` by object index.
std::vector<RawHypothesis> ClusterVotes(std::vector<RawHypothesis> raw,
                                        const std::vector<PoseDistance>& distances, double radius,
                                        int max_kept);

}  // namespace pickbed
