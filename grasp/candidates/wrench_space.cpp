#include "grasp/candidates/wrench_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <queue>
#include <vector>

#include "scenes/geometry/decompositions.h"

namespace pickbed::grasp {
namespace {

constexpr int kMaxNearestSteps = 200;  // Wolfe's method terminates, but rounding could prevent it

// Points whose convex combination is the current nearest point, and their weights.
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

  // Moves to the nearest point of the convex hull and removes points that it does not need.
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
  // Weights (sum 1) of the point nearest to zero in the affine hull of all points.
  Eigen::VectorXd NearestOfAffineHull() const {
    const int n = static_cast<int>(points_.size());
    Eigen::Matrix<double, 6, Eigen::Dynamic> edges(6, n - 1);
    for (int i = 1; i < n; ++i) edges.col(i - 1) = points_[i] - points_[0];
    Eigen::VectorXd weights(n);
    if (n > 1) {
      weights.tail(n - 1) = MinimumNormSolution(edges, -points_[0]);
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
  // Searches for the point nearest to zero of the set shifted by the load.
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
    // The plane through `next`, normal to `nearest`, separates the set from zero.
    if (nearest.dot(next) > tolerance * distance) return false;
    if (corral.Has(next)) return false;
    corral.Add(next);
    corral.Settle();
  }
  return false;
}

namespace {

constexpr int kDim = 6;
constexpr double kSameDirection = 0.1;  // an axis with a smaller residual counts as inside a span

// Linear span of some vectors, as a growing orthonormal basis.
class Span {
 public:
  // Component of v orthogonal to the span. The second pass removes the rounding error of the first.
  Wrench Residual(Wrench v) const {
    for (int pass = 0; pass < 2; ++pass) {
      for (int i = 0; i < size_; ++i) v -= basis_[i].dot(v) * basis_[i];
    }
    return v;
  }
  void Add(const Wrench& v) { basis_[size_++] = Residual(v).normalized(); }
  // Unit vector orthogonal to the span, from the axis with the smallest component in the span.
  Wrench Normal() const {
    Wrench within = Wrench::Zero();  // squared length of each axis in the span
    for (int i = 0; i < size_; ++i) within += basis_[i].cwiseAbs2();
    int axis = 0;
    within.minCoeff(&axis);
    return Residual(Residual(Wrench::Unit(axis)).normalized()).normalized();
  }

 private:
  std::array<Wrench, kDim> basis_;
  int size_ = 0;
};

// Simplex of six points; neighbor i is opposite to point i.
struct Facet {
  std::array<int, kDim> points;
  std::array<int, kDim> neighbors;
  Wrench normal;  // unit, outward
  double offset = 0;
  bool alive = true;
};

class Polytope {
 public:
  Polytope(const WrenchSet& set, const WrenchDepthOptions& options) : set_(set), options_(options) {
    MakeSimplex();
  }

  WrenchDepth Depth() {
    if (flat_) return {};
    WrenchDepth depth{0, std::numeric_limits<double>::infinity()};
    while (!nearest_.empty()) {
      const int index = nearest_.top().second;
      if (!facets_[index].alive) {
        nearest_.pop();
        continue;
      }
      const Facet& facet = facets_[index];
      const Wrench point = set_.Support(facet.normal);
      const double reach = facet.normal.dot(point);
      depth.upper = std::min(depth.upper, std::max(0.0, reach));
      depth.lower = std::clamp(facet.offset, 0.0, depth.upper);
      if (reach <= 0) return {};
      const double gap = std::max(options_.tolerance * depth.upper, coplanar_);
      if (reach - facet.offset <= gap || depth.upper - depth.lower <= gap) return depth;
      if (static_cast<int>(facets_.size()) > options_.max_facets) return depth;
      if (!Grow(index, point)) return depth;
    }
    return depth;
  }

 private:
  // Builds the first simplex from seven points of the set. Each point is the furthest one along a
  // direction that the previous points do not span.
  void MakeSimplex() {
    Span span;
    points_.push_back(set_.Support(Wrench::UnitX()));
    double size = 0;
    for (int k = 0; k < kDim; ++k) {
      const Wrench opposite = set_.Support(-Wrench::Unit(k));
      size = std::max(size, (set_.Support(Wrench::Unit(k)) - opposite).norm());
    }
    coplanar_ = options_.coplanar_share * size;
    for (int k = 0; k < kDim; ++k) {
      Wrench best = points_[0];
      double best_height = 0;
      for (int i = 0; i < kDim; ++i) {
        const Wrench square = span.Residual(Wrench::Unit(i));
        if (square.norm() < kSameDirection) continue;
        for (const double sign : {1.0, -1.0}) {
          const Wrench direction = sign * square.normalized();
          const Wrench point = set_.Support(direction);
          const double height = direction.dot(point - points_[0]);
          if (height > best_height) {
            best_height = height;
            best = point;
          }
        }
      }
      if (!(best_height > options_.flat_share * size)) {
        flat_ = true;
        return;
      }
      points_.push_back(best);
      span.Add(best - points_[0]);
    }
    for (const Wrench& point : points_) inside_ += point / points_.size();
    for (int left_out = 0; left_out <= kDim; ++left_out) {
      std::array<int, kDim> points;
      std::array<int, kDim> neighbors;
      for (int i = 0, k = 0; i <= kDim; ++i) {
        if (i == left_out) continue;
        points[k] = i;
        neighbors[k++] = i;  // facet i does not contain point i
      }
      AddFacet(points, neighbors);
    }
  }

  int AddFacet(const std::array<int, kDim>& points, const std::array<int, kDim>& neighbors) {
    Facet facet{points, neighbors, {}, 0, true};
    Span span;
    for (int i = 1; i < kDim; ++i) span.Add(points_[points[i]] - points_[points[0]]);
    facet.normal = span.Normal();
    facet.offset = facet.normal.dot(points_[points[0]]);
    if (facet.normal.dot(inside_) > facet.offset) {
      facet.normal = -facet.normal;
      facet.offset = -facet.offset;
    }
    facets_.push_back(facet);
    const int index = static_cast<int>(facets_.size()) - 1;
    nearest_.emplace(-facet.offset, index);
    return index;
  }

  // Side of a new facet whose neighbor is another new facet. Both share the apex and four more
  // points, which are packed in two numbers, because the sides are sorted by them.
  struct OpenSide {
    std::array<std::uint64_t, 2> shared;
    int facet;
    int side;
    bool operator<(const OpenSide& other) const { return shared < other.shared; }
  };

  // Returns the points without the apex and `left_out`, sorted and packed.
  static std::array<std::uint64_t, 2> SharedPoints(const std::array<int, kDim>& points, int apex,
                                                   int left_out) {
    std::array<std::uint32_t, kDim - 2> rest;
    for (int p = 0, k = 0; p < kDim; ++p) {
      if (p != left_out && points[p] != apex) rest[k++] = static_cast<std::uint32_t>(points[p]);
    }
    std::sort(rest.begin(), rest.end());
    return {static_cast<std::uint64_t>(rest[0]) << 32 | rest[1],
            static_cast<std::uint64_t>(rest[2]) << 32 | rest[3]};
  }

  // Connects new facets that share a ridge. Returns false if some ridge is not shared by exactly
  // two.
  bool Join(std::vector<OpenSide>& open) {
    std::sort(open.begin(), open.end());
    for (size_t i = 0; i < open.size(); i += 2) {
      if (i + 1 == open.size() || open[i].shared != open[i + 1].shared) return false;
      facets_[open[i].facet].neighbors[open[i].side] = open[i + 1].facet;
      facets_[open[i + 1].facet].neighbors[open[i + 1].side] = open[i].facet;
    }
    return true;
  }

  // Removes every facet that is visible from the point, starting at `first`, and connects the
  // boundary of the hole to the point. Returns false if rounding makes the boundary inconsistent.
  bool Grow(int first, const Wrench& point) {
    const int apex = static_cast<int>(points_.size());
    points_.push_back(point);
    std::vector<int> visible{first};
    facets_[first].alive = false;
    struct Side {
      int facet;   // remaining facet
      int across;  // index of the side whose neighbor was removed
      std::array<int, kDim> points;
    };
    std::vector<Side> rim;
    for (size_t k = 0; k < visible.size(); ++k) {
      for (int i = 0; i < kDim; ++i) {
        const int gone = visible[k];
        const int other = facets_[gone].neighbors[i];
        if (!facets_[other].alive) continue;
        if (facets_[other].normal.dot(point) - facets_[other].offset > coplanar_) {
          facets_[other].alive = false;
          visible.push_back(other);
          continue;
        }
        std::array<int, kDim> points = facets_[gone].points;
        points[i] = apex;
        const auto& across = facets_[other].neighbors;
        const auto place = std::find(across.begin(), across.end(), gone) - across.begin();
        if (place == kDim) return false;
        rim.push_back({other, static_cast<int>(place), points});
      }
    }
    std::vector<OpenSide> open;
    for (const Side& side : rim) {
      // The facet itself may have been removed later in the loop above.
      if (!facets_[side.facet].alive) continue;
      std::array<int, kDim> neighbors;
      neighbors.fill(-1);
      const int made = AddFacet(side.points, neighbors);
      for (int i = 0; i < kDim; ++i) {
        if (side.points[i] == apex) {
          facets_[made].neighbors[i] = side.facet;
          facets_[side.facet].neighbors[side.across] = made;
        } else {
          open.push_back({SharedPoints(side.points, apex, i), made, i});
        }
      }
    }
    return Join(open);
  }

  const WrenchSet& set_;
  const WrenchDepthOptions& options_;
  std::vector<Wrench> points_;
  std::vector<Facet> facets_;
  // Facets by distance from zero, nearest first. Removed facets are skipped.
  std::priority_queue<std::pair<double, int>> nearest_;
  Wrench inside_ = Wrench::Zero();
  double coplanar_ = 0;
  bool flat_ = false;
};

}  // namespace

WrenchDepth DepthOfZero(const WrenchSet& set, const WrenchDepthOptions& options) {
  return Polytope(set, options).Depth();
}

}  // namespace pickbed::grasp
