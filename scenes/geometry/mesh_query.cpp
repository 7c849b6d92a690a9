#include "scenes/geometry/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kLeafSize = 4;
constexpr double kSamePlace = 1e-12;  // rounding of a line parameter, as a share of the mesh size

struct Corners {
  Eigen::Vector3d a, b, c;
  int triangle;
};

// Nodes are stored in depth-first order, so the first child follows its parent. `skip` is the index
// after this node's subtree. For a first child, it is the sibling.
struct Node {
  Eigen::Vector3d min, max;
  int begin, end;  // range of the corners in this subtree
  int skip;
  bool leaf() const { return end - begin <= kLeafSize; }
};

double SquaredDistanceToBox(const Node& node, const Eigen::Vector3d& p) {
  return (node.min - p).cwiseMax(p - node.max).cwiseMax(0.0).squaredNorm();
}

double Clamped01(double x) { return std::clamp(x, 0.0, 1.0); }

Eigen::Vector3d ClosestOnSegment(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                 const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = b - a;
  return a + Clamped01((p - a).dot(ab) / ab.squaredNorm()) * ab;
}

// Returns the foot of the perpendicular if it is inside, else the nearest point of the three sides.
Eigen::Vector3d ClosestOnTriangle(const Corners& t, const Eigen::Vector3d& p) {
  const Eigen::Vector3d normal = (t.b - t.a).cross(t.c - t.a);
  const auto inside_of = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return (to - from).cross(p - from).dot(normal) >= 0;
  };
  const bool in_ab = inside_of(t.a, t.b), in_bc = inside_of(t.b, t.c), in_ca = inside_of(t.c, t.a);
  if (in_ab && in_bc && in_ca) {
    return p - (p - t.a).dot(normal) / normal.squaredNorm() * normal;
  }
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double best_squared = kInfinity;
  const auto try_side = [&](bool inside, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    if (inside) return;  // the nearest point is on a side that has p on its outer side
    const Eigen::Vector3d q = ClosestOnSegment(from, to, p);
    const double squared = (q - p).squaredNorm();
    if (squared < best_squared) {
      best_squared = squared;
      best = q;
    }
  };
  try_side(in_ab, t.a, t.b);
  try_side(in_bc, t.b, t.c);
  try_side(in_ca, t.c, t.a);
  return best;
}

// A ray that is sheared to run along one axis (Woop, Benthin and Wald 2013). Adjacent triangles
// compute the same edge function for a shared side, so no ray passes between them.
class Ray {
 public:
  Ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction)
      : origin_(origin), direction_(direction) {
    direction.cwiseAbs().maxCoeff(&z_);
    x_ = (z_ + 1) % 3;
    y_ = (z_ + 2) % 3;
    if (direction[z_] < 0) std::swap(x_, y_);
    shear_x_ = direction[x_] / direction[z_];
    shear_y_ = direction[y_] / direction[z_];
    inverse_ = direction.cwiseInverse();
  }

  // Returns the line parameter of the hit, or infinity for a miss. A hit on a side counts.
  double Hit(const Corners& t) const {
    const Eigen::Vector3d a = Sheared(t.a), b = Sheared(t.b), c = Sheared(t.c);
    const double u = c.x() * b.y() - c.y() * b.x();
    const double v = a.x() * c.y() - a.y() * c.x();
    const double w = b.x() * a.y() - b.y() * a.x();
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return kInfinity;
    const double det = u + v + w;
    if (det == 0) return kInfinity;
    return (u * a.z() + v * b.z() + w * c.z()) / (det * direction_[z_]);
  }

  // Returns whether the line enters the box within [min_t, max_t]. It may return true for a near
  // miss, because the interval is widened by rounding errors.
  bool Meets(const Node& node, double min_t, double max_t) const {
    constexpr double kSlack = 1 + 8 * std::numeric_limits<double>::epsilon();
    for (int k = 0; k < 3; ++k) {
      if (direction_[k] == 0) {
        if (origin_[k] < node.min[k] || origin_[k] > node.max[k]) return false;
        continue;
      }
      double near = (node.min[k] - origin_[k]) * inverse_[k];
      double far = (node.max[k] - origin_[k]) * inverse_[k];
      if (near > far) std::swap(near, far);
      min_t = std::max(min_t, near > 0 ? near / kSlack : near * kSlack);
      max_t = std::min(max_t, far > 0 ? far * kSlack : far / kSlack);
    }
    return min_t <= max_t;
  }

 private:
  Eigen::Vector3d Sheared(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d q = p - origin_;
    return {q[x_] - shear_x_ * q[z_], q[y_] - shear_y_ * q[z_], q[z_]};
  }

  Eigen::Vector3d origin_, direction_, inverse_;
  int x_, y_, z_;
  double shear_x_, shear_y_;
};

}  // namespace

struct MeshQuery::Impl {
  std::vector<Corners> corners;
  std::vector<Node> nodes;
  std::vector<Eigen::Vector3d> normals;  // by triangle
  double size_m = 0;

  void Build(int begin, int end) {
    Node node{corners[begin].a, corners[begin].a, begin, end, 0};
    for (int i = begin; i < end; ++i) {
      const Corners& t = corners[i];
      node.min = node.min.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
      node.max = node.max.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
    }
    const size_t index = nodes.size();
    nodes.push_back(node);
    if (!node.leaf()) {
      int axis = 0;
      (node.max - node.min).maxCoeff(&axis);
      const int split = begin + (end - begin) / 2;
      std::nth_element(corners.begin() + begin, corners.begin() + split, corners.begin() + end,
                       [axis](const Corners& s, const Corners& t) {
                         return std::make_pair(s.a[axis] + s.b[axis] + s.c[axis], s.triangle) <
                                std::make_pair(t.a[axis] + t.b[axis] + t.c[axis], t.triangle);
                       });
      Build(begin, split);
      Build(split, end);
    }
    nodes[index].skip = static_cast<int>(nodes.size());
  }

  // Searches the subtree of a node. If it has a nearer point, lowers best_squared and sets point
  // and triangle of `best`.
  void Closest(int index, const Eigen::Vector3d& p, SurfaceHit& best, double& best_squared) const {
    const Node& node = nodes[index];
    if (node.leaf()) {
      for (int i = node.begin; i < node.end; ++i) {
        const Eigen::Vector3d q = ClosestOnTriangle(corners[i], p);
        const double squared = (q - p).squaredNorm();
        if (squared >= best_squared) continue;
        best_squared = squared;
        best.point = q;
        best.triangle = corners[i].triangle;
      }
      return;
    }
    int near = index + 1, far = nodes[near].skip;
    double near_squared = SquaredDistanceToBox(nodes[near], p);
    double far_squared = SquaredDistanceToBox(nodes[far], p);
    if (far_squared < near_squared) {
      std::swap(near, far);
      std::swap(near_squared, far_squared);
    }
    if (near_squared < best_squared) Closest(near, p, best, best_squared);
    if (far_squared < best_squared) Closest(far, p, best, best_squared);
  }

  bool HasWithin(const Eigen::Vector3d& p, double distance_m) const {
    // The slack keeps boxes that would be skipped only because the square is rounded.
    constexpr double kSlack = 1 + 8 * std::numeric_limits<double>::epsilon();
    const double max_squared = kSlack * distance_m * distance_m;
    for (int index = 0; index < static_cast<int>(nodes.size());) {
      const Node& node = nodes[index];
      if (SquaredDistanceToBox(node, p) > max_squared) {
        index = node.skip;
        continue;
      }
      for (int i = node.begin; node.leaf() && i < node.end; ++i) {
        if ((ClosestOnTriangle(corners[i], p) - p).norm() <= distance_m) return true;
      }
      ++index;
    }
    return false;
  }

  // Calls take(t, triangle) for each hit with min_t < t < max_t. `take` returns the new max_t.
  template <typename Take>
  void ForHits(const Ray& ray, double min_t, double max_t, const Take& take) const {
    for (int index = 0; index < static_cast<int>(nodes.size());) {
      const Node& node = nodes[index];
      if (!ray.Meets(node, min_t, max_t)) {
        index = node.skip;
        continue;
      }
      for (int i = node.begin; node.leaf() && i < node.end; ++i) {
        const double t = ray.Hit(corners[i]);
        if (t > min_t && t < max_t) max_t = take(t, corners[i].triangle);
      }
      ++index;
    }
  }

  SurfaceHit MakeHit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double t,
                     int triangle) const {
    return {origin + t * direction, normals[triangle], triangle, t};
  }
};

MeshQuery::MeshQuery(const TriangleMesh& mesh) : impl_(std::make_unique<Impl>()) {
  impl_->normals = FaceNormals(mesh);
  impl_->size_m = MeshBounds(mesh).size().norm();
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (impl_->normals[i].isZero(0)) continue;  // a face without area cannot be hit
    const Eigen::Vector3i& t = mesh.triangles[i];
    impl_->corners.push_back(
        {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], static_cast<int>(i)});
  }
  CheckInput(!impl_->corners.empty(), "a mesh without faces cannot be queried");
  impl_->Build(0, static_cast<int>(impl_->corners.size()));
}

MeshQuery::~MeshQuery() = default;
MeshQuery::MeshQuery(MeshQuery&&) noexcept = default;

SurfaceHit MeshQuery::ClosestPoint(const Eigen::Vector3d& p) const {
  SurfaceHit best{};
  double best_squared = kInfinity;
  impl_->Closest(0, p, best, best_squared);
  CheckInput(best.triangle >= 0, "the point of a query is not finite or too far from the mesh");
  best.normal = impl_->normals[best.triangle];
  best.distance = std::sqrt(best_squared);
  return best;
}

bool MeshQuery::IsWithin(const Eigen::Vector3d& p, double distance_m) const {
  return impl_->HasWithin(p, distance_m);
}

std::optional<SurfaceHit> MeshQuery::Raycast(const Eigen::Vector3d& origin,
                                             const Eigen::Vector3d& direction, double min_t,
                                             double max_t) const {
  int triangle = -1;
  double first_t = max_t;
  impl_->ForHits(Ray(origin, direction), min_t, max_t, [&](double t, int hit) {
    triangle = hit;
    return first_t = t;
  });
  if (triangle < 0) return std::nullopt;
  return impl_->MakeHit(origin, direction, first_t, triangle);
}

std::vector<SurfaceHit> MeshQuery::AllHits(const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction) const {
  std::vector<SurfaceHit> hits;
  impl_->ForHits(Ray(origin, direction), -kInfinity, kInfinity, [&](double t, int triangle) {
    hits.push_back(impl_->MakeHit(origin, direction, t, triangle));
    return kInfinity;
  });
  std::sort(hits.begin(), hits.end(), [](const SurfaceHit& a, const SurfaceHit& b) {
    return std::make_pair(a.distance, a.triangle) < std::make_pair(b.distance, b.triangle);
  });
  // A line through a shared side meets both faces at the same place. This is one crossing, so only
  // one of the two hits is kept.
  const double same_place_m = kSamePlace * impl_->size_m;
  const auto one_crossing = [&](const SurfaceHit& a, const SurfaceHit& b) {
    return b.distance - a.distance <= same_place_m &&
           (a.normal.dot(direction) < 0) == (b.normal.dot(direction) < 0);
  };
  hits.erase(std::unique(hits.begin(), hits.end(), one_crossing), hits.end());
  return hits;
}

}  // namespace pickbed::scenes
