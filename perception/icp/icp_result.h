#pragma once

// Result of all ICP variants. ProjectiveIcp and BidirectionalIcp take (cloud, model, X_CO,
// options). PclIcp holds cloud and options, because all poses of a frame share its search tree.
// RefinePose in final_refinement.h is the common interface.

#include <cstdint>

#include "perception/layer.h"
#include "scenes/geometry/pose.h"

namespace pickbed::perception {

// How a refinement ended. Only kRefined is a success.
enum class IcpStatus : uint8_t {
  kRefined,                // X_CO is the refined pose
  kTooFewCorrespondences,  // fewer correspondences than the six unknowns need
  kStepTooLarge,           // a step left the range in which the correspondences are valid
  kWorse,                  // the refined pose agrees less with the image, so it was discarded
};

// Result of a refinement. Inlier fraction, rmse_m and reciprocal_condition_number describe X_CO.
struct IcpResult {
  // Refined pose. After a failure: the last valid pose of ProjectiveIcp, the start pose of the
  // other variants.
  Pose X_CO = Pose::Identity();
  IcpStatus status = IcpStatus::kTooFewCorrespondences;
  int iterations = 0;          // steps from the start pose to X_CO
  double inlier_fraction = 0;  // fraction of the used model points with a surface correspondence
  double rmse_m = 0;           // root mean square of their point-to-plane distances
  // Smallest over largest eigenvalue of the surface's normal equations, rotations scaled to motion
  // at the object's radius. 0 = the pose can slide.
  double reciprocal_condition_number = 0;
  // Agreement with the image that decides between kRefined and kWorse; higher is better. Each
  // variant documents its own measure. ProjectiveIcp has none and leaves both at 0.
  double start_agreement = 0, agreement = 0;
};

}  // namespace pickbed::perception
