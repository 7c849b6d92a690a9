#include "grasp/wrench_space.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace pickbed {
namespace {

constexpr int kMaxNearestSteps =
    200;  // Wolfe's method ends by itself; rounding could keep it going

// The points that the nearest one is a combination of, and with which weights.
class Corral {
 public:
  void Add(const Wrench& point) {
    points_.push_back(point);
    weights_.push_back(points_.size() == 1 ? 1.0 : 0.0);
  }

  Wrench Point() const {
    Wrench sum = Wrench::Zero();
    for (size_t i = 0; i < points_.size(); ++i) sum += weights_[i] * points_[i];
    return sum;
  }

  bool Has(const Wrench& point) const {
    for (const Wrench& p : points_) {
      if (p == point) return true;
    }
    return false;
  }

  // Moves to the nearest point of the corral's hull, leaving out points that it does not need.
  void Settle() {
    for (;;) {
      const Eigen::VectorXd flat = NearestOfAffineHull();
      double step = 1;
      int leaves = -1;
      for (int i = 0; i < flat.size(); ++i) {
        if (flat[i] > 0) continue;
        const double share = weights_[i] / (weights_[i] - flat[i]);
        if (leaves < 0 || share < step) {
          step = std::min(1.0, share);
          leaves = i;
        }
      }
      for (int i = 0; i < flat.size(); ++i) weights_[i] += step * (flat[i] - weights_[i]);
      if (leaves < 0) return;
      points_.erase(points_.begin() + leaves);
      weights_.erase(weights_.begin() + leaves);
    }
  }

 private:
  // Weights, which sum to 1, of the point nearest to zero on the flat through all points.
  Eigen::VectorXd NearestOfAffineHull() const {
    const int n = static_cast<int>(points_.size());
    Eigen::Matrix<double, 6, Eigen::Dynamic> edges(6, n - 1);
    for (int i = 1; i < n; ++i) edges.col(i - 1) = points_[i] - points_[0];
    Eigen::VectorXd weights(n);
    if (n > 1) {
      weights.tail(n - 1) = edges.completeOrthogonalDecomposition().solve(-points_[0]);
    }
    weights[0] = 1 - weights.tail(n - 1).sum();
    return weights;
  }

  std::vector<Wrench> points_;
  std::vector<double> weights_;
};

}  // namespace

Wrench WrenchSet::Support(const Wrench& direction) const {
  Wrench sum = offset;
  for (const Wrenches& region : regions) {
    if (region.cols() == 0) continue;
    Eigen::Index best = 0;
    if ((direction.transpose() * region).maxCoeff(&best) > 0) sum += region.col(best);
  }
  return sum;
}

Wrenches ConeEdges(const ContactCone& cone, int edges, double radius_m) {
  const Eigen::Vector3d u = cone.inward.unitOrthogonal();
  const Eigen::Vector3d v = cone.inward.cross(u);
  Wrenches wrenches(6, edges);
  for (int k = 0; k < edges; ++k) {
    const double turn = 2 * std::numbers::pi * k / edges;
    const Eigen::Vector3d force =
        cone.force * (cone.inward + cone.friction * (std::cos(turn) * u + std::sin(turn) * v));
    wrenches.col(k) << force, cone.point.cross(force) / radius_m;
  }
  return wrenches;
}

bool Balances(const WrenchSet& set, const Wrench& load, double tolerance) {
  // The nearest point to zero of the set moved by the load.
  const auto support = [&](const Wrench& direction) -> Wrench {
    return set.Support(direction) + load;
  };
  Corral corral;
  corral.Add(support(-load - set.offset));
  for (int step = 0; step < kMaxNearestSteps; ++step) {
    const Wrench nearest = corral.Point();
    const double distance = nearest.norm();
    if (distance < tolerance) return true;
    const Wrench next = support(-nearest);
    // Everything lies beyond the plane through `next` square to the way here: never within reach.
    if (nearest.dot(next) > tolerance * distance) return false;
    if (corral.Has(next)) return false;
    corral.Add(next);
    corral.Settle();
  }
  return false;
}

}  // namespace pickbed
