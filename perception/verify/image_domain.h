#pragma once

// Comparison of an image with the images of the training. Scores are calibrated on simulated
// images. Outside their range, a score is less reliable, so it is lowered.

#include <string>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"

namespace pickbed::perception {

// Ranges of the images of the training (guides/training.md).
inline constexpr double kMaxHoleShare = 0.45;  // share of the pixels between readings of a row
inline constexpr double kMinDiameter_px = 20;  // diameter of an object in the image
inline constexpr double kMaxTilt_rad = 1.25;   // of the optical axis from the floor normal

// Smallest diameter of an object in the image where the background is not given. In simulated
// rooms, nearly all poses with a smaller one are wrong (docs/pages/benchmarks_rooms.md): they are
// on details of the surroundings.
inline constexpr double kMinRoomDiameter_px = 45;

// Share of the near side of an object outside the image. The verifier counts no evidence there. The
// value is chosen, not measured.
inline constexpr double kMaxOutsideShare = 0.25;

struct ImageDomain {
  double hole_share = 0;
  double error_at_1m_m = 0;  // standard deviation; at most kMaxTrainedError_m in the training
  double tilt_rad = 0;       // 0 = no floor is known, or only a short steep plane
  double min_diameter_px = kMinDiameter_px;  // of an object without a penalty
};

// Measures the image of a cloud.
ImageDomain DomainOf(const OrganizedCloud& cloud);

// Returns the share of the points on the near side of an object at X_CO that are projected outside
// the image, 0..1.
double OutsideShare(const CameraIntrinsics& camera, const ModelPoints& model, const Pose& X_CO);

// Returns the diameter of an object at X_CO in the image, px. An object less than 1 mm in front of
// the camera counts as 1 mm in front of it.
double DiameterInImage_px(const CameraIntrinsics& camera, double diameter_m, const Pose& X_CO);

// Returns by how much the logit of a score is lowered, >= 0: the sum of the relative excesses over
// the ranges. It never falls with more holes, more noise, more tilt, a smaller diameter or a larger
// share of the object outside the image.
double LogitPenalty(const ImageDomain& domain, double diameter_px, double outside_share);

// Returns one sentence for each range that is exceeded.
std::vector<std::string> DomainWarnings(const ImageDomain& domain);

}  // namespace pickbed::perception
