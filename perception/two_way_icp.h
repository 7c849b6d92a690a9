#pragma once

// ICP for a pose that is known only roughly, in both directions, with the outline as well as the
// surface: for the few poses that are worth some milliseconds each.
//
// Three kinds of residual make one Gauss-Newton step. Surface: a visible model point and the plane
// seen at its pixel (Chen and Medioni 1991). Outline: a model point where the camera looks through
// to what stands behind is drawn sideways to the nearest pixel that could show the part. Cover: a
// foreground point near the model is drawn to the model's surface. A real sensor flattens curved
// surfaces and loses them where they graze the ray; surface residuals alone then slide, or turn
// about, to where the flat patches agree, and the other two hold them. A hole may show anything and
// has no residual, nor has a model point with something before it.

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

struct TwoWayIcpOptions {
  double gate_m = 0.025;        // residuals beyond it do not count, at the start
  double gate_end_m = 0.015;    // reached by equal factors; wider than what a sensor is off by
  double gate_diameters = 0.2;  // no gate is wider than that
  int iterations = 30;
  double min_normal_cos = 0.5;
  double outline_weight = 1.0;  // of the outline's residuals, 1 = as the surface's
  double cover_weight = 1.0;    // of the cover's
  // Share of the mean of the normal equations' diagonal (Levenberg 1944).
  double damping = 0.01;
  int max_points = 600;         // the first of the visible model points
  int max_scene_pixels = 2000;  // of the box around the part, evenly strided
  // Also started from the start turned by this angle both ways about each of the camera's axes; the
  // result that agrees best with the image stands. 0 = one start.
  double restart_rad = 0.2;
};

struct TwoWayReport {
  Pose X_CO = Pose::Identity();
  double overlap = 0;       // share of the visible points that lie on the surface seen, at the end
  double residual_m = 0;    // rms point-to-plane of those
  double conditioning = 0;  // smallest over largest eigenvalue of the surface's normal equations,
                            // turns counted as motion at the part's radius; 0 = slides
  // Of a visible point, 1 = all lie exactly on the surface seen, -1 = the camera looks through all.
  double agreement = 0, agreement_before = 0;
  bool made_worse = false;  // agreement fell, so that X_CO is the start
};

// A start from which six residuals are not found or a step leaves the gate ends at its last good
// pose. Deterministic.
TwoWayReport TwoWayIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                       const TwoWayIcpOptions& options = {});

// The same as the final refiner of a reported pose: sets its X_CO, unrefined_X_CO and fit.
void RefineTwoWay(const OrganizedCloud& cloud, const ModelPoints& model, PoseHypothesis& hypothesis,
                  const TwoWayIcpOptions& options = {});

}  // namespace pickbed
