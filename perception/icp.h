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
  int max_points = 400;
};

// Holds the search tree of one frame, shared by all hypotheses.
class PclRefiner {
 public:
  PclRefiner(const OrganizedCloud& cloud, const PclIcpOptions& options = {});
  ~PclRefiner();
  // Refines X_CO in place and fills fit.refinement_kept and fit.residual_m.
  void Refine(const ModelPoints& model, PoseHypothesis& hypothesis) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
