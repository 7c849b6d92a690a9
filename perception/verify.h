#pragma once

// How well a pose explains the image: a quick score for thousands of raw hypotheses, and a learned
// verifier for those that survive ICP. A hole in the depth is unknown, never a violation.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// (inliers - violations) / points over at most `max_points` visible points, band tau_m. No
// allocation.
double QuickScore(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                  double tau_m = 0.008, int max_points = 120);

inline constexpr int kVerifyFeatures = 10;
using VerifyFeatures = std::array<float, kVerifyFeatures>;

// In order: inlier, hidden, violated, wrong-normal and tight-inlier shares; near and farther
// unexplained scene points; log visible points; log agreeing raw votes; explained share.
VerifyFeatures ComputeVerifyFeatures(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, double agreeing_votes, FitReport& fit);

// A 10-24-1 perceptron with tanh, inputs standardised; output P(pose right).
struct Verifier {
  Eigen::VectorXf mean, scale;  // 10
  Eigen::MatrixXf w1;           // 24 x 10
  Eigen::VectorXf b1, w2;       // 24
  float b2 = 0;
  double Score(const VerifyFeatures& features) const;
};

}  // namespace pickbed
