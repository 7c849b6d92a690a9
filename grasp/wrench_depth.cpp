#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "grasp/wrench_space.h"

namespace pickbed {
namespace {

constexpr int kDim = 6;
constexpr double kSameDirection = 0.1;  // an axis with less than this beyond a span lies in it

// The flat that some vectors span, as an orthonormal basis that grows.
class Span {
 public:
  // What of v is square to the span; twice, since the first time leaves rounding.
  Wrench Residual(Wrench v) const {
    for (int pass = 0; pass < 2; ++pass) {
      for (int i = 0; i < size_; ++i) v -= basis_[i].dot(v) * basis_[i];
    }
    return v;
  }
  void Add(const Wrench& v) { basis_[size_++] = Residual(v).normalized(); }
  // A unit vector square to the span: what is left of the axis that has least in it.
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

// A simplex of six points; across from point i lies neighbour i.
struct Facet {
  std::array<int, kDim> points;
  std::array<int, kDim> neighbors;
  Wrench normal;  // unit, outward
  double offset = 0;
  bool alive = true;
};

// What of a facet's rim two facets share: all points but one, sorted.
using Ridge = std::array<int, kDim - 1>;

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
  // Seven points of the set that span as much as its extent along each new direction allows.
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
        neighbors[k++] = i;  // facet i is the one that leaves point i out
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

  // A side of a new facet whose neighbour is another new one.
  struct OpenSide {
    Ridge ridge;
    int facet;
    int side;
    bool operator<(const OpenSide& other) const { return ridge < other.ridge; }
  };

  static Ridge RidgeWithout(const std::array<int, kDim>& points, int left_out) {
    Ridge ridge;
    for (int p = 0, k = 0; p < kDim; ++p) {
      if (p != left_out) ridge[k++] = points[p];
    }
    std::sort(ridge.begin(), ridge.end());
    return ridge;
  }

  // Makes neighbours of those that share a ridge; false when some ridge is not shared by two.
  bool Join(std::vector<OpenSide>& open) {
    std::sort(open.begin(), open.end());
    for (size_t i = 0; i < open.size(); i += 2) {
      if (i + 1 == open.size() || open[i].ridge != open[i + 1].ridge) return false;
      facets_[open[i].facet].neighbors[open[i].side] = open[i + 1].facet;
      facets_[open[i + 1].facet].neighbors[open[i + 1].side] = open[i].facet;
    }
    return true;
  }

  // Takes away every facet that sees the point, from `first` on, and joins the rim of the hole to
  // it. False when rounding leaves a rim that is none.
  bool Grow(int first, const Wrench& point) {
    const int apex = static_cast<int>(points_.size());
    points_.push_back(point);
    std::vector<int> visible{first};
    facets_[first].alive = false;
    struct Side {
      int facet;   // that stays
      int across;  // which of its neighbours went
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
      // A facet that a later one of the loop above took away has lost its rim.
      if (!facets_[side.facet].alive) continue;
      std::array<int, kDim> neighbors;
      neighbors.fill(-1);
      const int made = AddFacet(side.points, neighbors);
      for (int i = 0; i < kDim; ++i) {
        if (side.points[i] == apex) {
          facets_[made].neighbors[i] = side.facet;
          facets_[side.facet].neighbors[side.across] = made;
        } else {
          open.push_back({RidgeWithout(side.points, i), made, i});
        }
      }
    }
    return Join(open);
  }

  const WrenchSet& set_;
  const WrenchDepthOptions& options_;
  std::vector<Wrench> points_;
  std::vector<Facet> facets_;
  // Nearest to zero first; facets that are gone are passed over.
  std::priority_queue<std::pair<double, int>> nearest_;
  Wrench inside_ = Wrench::Zero();
  double coplanar_ = 0;
  bool flat_ = false;
};

}  // namespace

WrenchDepth DepthOfZero(const WrenchSet& set, const WrenchDepthOptions& options) {
  return Polytope(set, options).Depth();
}

}  // namespace pickbed
