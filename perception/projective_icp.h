#pragma once

// Point-to-plane ICP by projection, for hundreds of hypotheses a frame: each visible model point
// is paired with the pixel that it falls on, or else with one half a gate beside it, if that lies
// within a SMALL gate (a wide one slides into clutter) and the normals agree. Chen and Medioni
// 1991; Rusinkiewicz and Levoy 2001.

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

struct ProjectiveIcpOptions {
  double gate_m = 0.010;      // at the start
  double gate_end_m = 0.003;  // reached linearly
  int coarse_iterations = 12;
  int fine_iterations = 4;  // at gate_end_m
  double min_normal_cos = 0.5;
  int max_points = 150;  // the first of the visible subset; at most 512
  // Share of the mean of the normal equations' diagonal (Levenberg 1944). It slows directions that
  // few points hold, so that the others settle first. In simulated piles 0.05 brings 95 % of the
  // starts 10 degrees and 5 mm off home, against 85 % at 0.001; above 0.1 the result is less exact.
  double damping = 0.05;
};

struct IcpReport {
  Pose X_CO = Pose::Identity();
  double overlap = 0;       // share of the used points that found a partner at the end
  double residual_m = 0;    // rms point-to-plane at the end
  double conditioning = 0;  // smallest over largest eigenvalue of the normal equations, turns
                            // counted as motion at the part's radius; 0 = slides
};

// Stops where fewer than six points find a partner or a step leaves the gate; the report then tells
// of the last good pose. No allocation.
IcpReport ProjectiveIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                        const ProjectiveIcpOptions& options = {});

}  // namespace pickbed
