#pragma once

// Comparison of candidates with each other: the evident candidates, the evidence margin of each
// candidate over its rivals, and its penetration of the evident candidates.

#include <Eigen/Core>
#include <vector>

#include "perception/model/model_points.h"
#include "perception/pose_hypothesis.h"
#include "perception/verify/pose_features.h"
#include "perception/voting/pose_clustering.h"

namespace pickbed::perception {

// A refined pose with the inputs of the verifier.
struct Candidate {
  PoseHypothesis
      hypothesis;  // score = quick score within the final correspondence distance; fit is filled
  VerifyFeatures features{};
  double evidence = 0;  // nats, see depth_evidence.h
};

// Poses whose centers are nearer than this, in diameters, are at the same place.
inline constexpr double kSamePlaceDiameters = 0.2;

// Limits the number of poses at each place.
class Crowding {
 public:
  explicit Crowding(double radius_m) : radius_m_(radius_m) {}

  // Counts the pose and returns true, unless `max_poses` poses are already within radius_m of it.
  bool Admit(const Eigen::Vector3d& center_C, int max_poses);

 private:
  double radius_m_;
  std::vector<Eigen::Vector3d> centers_C_;
};

// Fills the feature kMarginFeature: the evidence margin over the best rival, or 1 without a rival.
// A rival is a different pose of the object at nearly the same place. All `candidates` are of the
// object `model`.
void FillMargins(const PoseDistance& distance, const ModelPoints& model,
                 const std::vector<Candidate*>& candidates);

// Returns the candidates that agree with nearly all of their visible pixels, one per place and
// object, by decreasing evidence. `models` is by object index.
std::vector<const Candidate*> EvidentCandidates(const std::vector<Candidate>& candidates,
                                                const std::vector<ModelPoints>& models);

// Returns the maximum penetration of the candidate with the evident ones, over the smaller
// diameter, at most 0.25. Poses of the same object at the same place are ignored. Other objects
// count only if they have more evidence. A wrong pose of one object may fit a face of another
// object well, but it is no argument against a pose that explains more.
double OverlapWith(const std::vector<const Candidate*>& evident, const Candidate& candidate,
                   const std::vector<ModelPoints>& models);

}  // namespace pickbed::perception
