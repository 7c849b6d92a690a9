#pragma once

// Bidirectional ICP with surface and outline residuals, for a pose that is known only roughly. It
// takes some milliseconds per pose.
//
// Each Gauss-Newton step uses three kinds of residuals:
// - Surface: a visible model point and the observed plane at its pixel (Chen and Medioni 1991).
// - Outline: a model point with a reading behind it is pulled sideways to the nearest pixel that
//   could show the object.
// - Cover: a foreground point near the model is pulled to the model surface.
// A real sensor flattens curved surfaces and loses them at grazing angles. With only surface
// residuals the pose then slides or rotates to where the flat patches agree; the other two kinds
// prevent this. Holes and occluded model points contribute no residual.

#include "perception/cloud/organized_cloud.h"
#include "perception/icp/icp_result.h"
#include "perception/model/model_points.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct BidirectionalIcpOptions {
  double max_correspondence_distance_m = 0.025;  // at the start; limits all kinds of residuals
  // The same in the last iteration, reached by equal factors; larger than the sensor error.
  double final_correspondence_distance_m = 0.015;
  double max_correspondence_distance_diameters = 0.2;  // upper limit of both, in diameters
  int iterations = 30;
  double min_normal_cos = 0.5;
  double outline_weight = 1.0;  // weight of outline residuals; surface residuals have weight 1
  double cover_weight = 1.0;    // weight of cover residuals
  // Added to the diagonal of the normal equations, as a share of its mean (Levenberg 1944).
  double damping = 0.01;
  int max_points = 600;         // the first of the visible model points are used
  int max_scene_pixels = 2000;  // of the box around the object, evenly strided
  // Additional starts: the start rotated by plus and minus this angle about each camera axis. The
  // result that agrees best with the image is returned. 0 = one start.
  double restart_rad = 0.2;
  void Visit(SettingsVisitor& v);
};

// Refines X_CO. A start ends early at its last valid pose if fewer than six residuals are found or
// if a step exceeds twice the maximum correspondence distance. Deterministic.
//
// The agreement is a mean over the visible points: 1 = all are exactly on the observed surface, -1
// = all readings are behind the model. The result is the start pose if the agreement would decrease
// (kWorse), or if the surface has fewer than six correspondences (kTooFewCorrespondences).
IcpResult BidirectionalIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                           const BidirectionalIcpOptions& options = {});

}  // namespace pickbed::perception
