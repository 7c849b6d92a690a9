#pragma once

// PCL's ICP as the final refiner of reported poses. Says whether it made the pose worse, in which
// case the old one is kept.

#include <memory>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

struct PclIcpOptions {
  double max_correspondence_m = 0.005;
  int iterations = 15;
  int max_points = 300;      // the first of the visible model points
  int target_stride = 2;     // every so many foreground pixels of a row and rows are searched
  double epsilon_m2 = 1e-9;  // stops when a step's squared shift is less
};

// Holds the search tree of one frame, shared by all hypotheses. `cloud` must outlive it.
class PclRefiner {
 public:
  explicit PclRefiner(const OrganizedCloud& cloud, const PclIcpOptions& options = {});
  ~PclRefiner();
  PclRefiner(PclRefiner&&) noexcept;

  // Point-to-plane ICP the first of the visible model points against the frame. The new X_CO is
  // kept when MeasureFit says that it is no worse: inliers less what they miss by, minus
  // violations. hypothesis.fit then describes the pose that stands; fit.refinement_kept says which
  // one, fit.conditioning whether anything holds it.
  void Refine(const ModelPoints& model, PoseHypothesis& hypothesis) const;

 private:
  void Align(const ModelPoints& model, PoseHypothesis& hypothesis) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
