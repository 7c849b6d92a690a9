#include "perception/training/logit_calibration.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace pickbed::perception {

Calibration Calibrate(const std::vector<ScoredPose>& poses) {
  constexpr double kPrior = 2;  // strength of the prior towards scale 1, shift 0, in poses
  constexpr int kSteps = 30;
  constexpr double kMinScale = 0.2;   // positive, so that the order of scores is kept
  const Eigen::Vector2d start(1, 0);  // scale, shift
  const auto loss = [&](const Eigen::Vector2d& x) {
    double sum = 0.5 * kPrior * (x - start).squaredNorm();
    for (const ScoredPose& pose : poses) {
      const double z = (pose.right ? -1 : 1) * (x[0] * pose.logit + x[1]);
      sum += std::max(z, 0.0) + std::log1p(std::exp(-std::abs(z)));
    }
    return sum;
  };
  Eigen::Vector2d x = start;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Vector2d gradient = kPrior * (x - start);
    Eigen::Matrix2d hessian = kPrior * Eigen::Matrix2d::Identity();
    for (const ScoredPose& pose : poses) {
      const Eigen::Vector2d input(pose.logit, 1);
      const double p = 1 / (1 + std::exp(-x.dot(input)));
      gradient += (p - pose.right) * input;
      hessian += p * (1 - p) * input * input.transpose();
    }
    Eigen::Vector2d full = hessian.ldlt().solve(gradient);
    // At its limit, the scale stays, and the shift does what the scale cannot.
    if (x[0] <= kMinScale && gradient[0] > 0) full = {0, gradient[1] / hessian(1, 1)};
    const auto moved = [&](double share) {
      const Eigen::Vector2d to = x - share * full;
      return Eigen::Vector2d(std::max(to[0], kMinScale), to[1]);
    };
    // If the logits are nearly equal, full Newton steps overshoot.
    const double before = loss(x);
    double share = 1;
    while (share > 1e-6 && loss(moved(share)) > before) share *= 0.5;
    x = moved(share);
  }
  return {static_cast<float>(x[0]), static_cast<float>(x[1])};
}

}  // namespace pickbed::perception
