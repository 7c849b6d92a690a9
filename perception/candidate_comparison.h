#pragma once

// What candidates say of each other: which of them are evident, by how much each is ahead of its
// rivals, and how deep it lies in what is evident.

#include <Eigen/Core>
#include <vector>

#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"
#include "perception/verify.h"
#include "perception/votes.h"

namespace pickbed {

struct Candidate {
  PoseHypothesis hypothesis;  // score = quick score in the fine gate; fit is filled
  VerifyFeatures features{};
  double evidence = 0;  // nats, see depth_evidence.h
};

// Poses whose middles are less than this apart are of one place.
inline constexpr double kSamePlaceDiameters = 0.2;

// How many poses lie at each place so far.
class Crowding {
 public:
  explicit Crowding(double radius_m) : radius_m_(radius_m) {}

  // False when there are `most` at this place already; counts the pose otherwise.
  bool Admit(const Eigen::Vector3d& middle_C, int most);

 private:
  double radius_m_;
  std::vector<Eigen::Vector3d> middles_C_;
};

// Fills in by how much the evidence exceeds that for the best rival: another pose of the part at
// the same place. 1 where there is none. `candidates` are all of the part `model`.
void FillMargins(const PoseDistance& distance, const ModelPoints& model,
                 const std::vector<Candidate*>& candidates);

// Those that fit nearly all that can be seen of them, one of a place, most evidence first. `models`
// by object.
std::vector<const Candidate*> EvidentCandidates(const std::vector<Candidate>& candidates,
                                                const std::vector<ModelPoints>& models);

// How deep the candidate lies in the evident ones, other poses of its own place aside, over the
// smaller diameter; 0.25 at most. Of other parts only those count that there is more evidence for:
// a wrong pose of one may fit a face of another well, and says nothing of a pose that explains
// more.
double OverlapWith(const std::vector<const Candidate*>& evident, const Candidate& candidate,
                   const std::vector<ModelPoints>& models);

}  // namespace pickbed
