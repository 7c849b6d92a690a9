#include "scenes/geometry/edge_collapse.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

namespace pickbed::scenes {
namespace {

// A triangle must not rotate by more than about 75 degrees in one collapse, because it could then
// fold over.
constexpr double kMinNormalCosine = 0.25;

using Triangle = std::array<Eigen::Vector3d, 3>;

Eigen::Vector3d AreaVector(const Triangle& t) { return (t[1] - t[0]).cross(t[2] - t[0]); }

double SquaredDistanceToSegment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp(d.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * d).squaredNorm();
}

double SquaredDistance(const Eigen::Vector3d& p, const Triangle& t) {
  const Eigen::Vector3d n = AreaVector(t);
  const double n2 = n.squaredNorm();
  const bool over_inside = n2 > 0 && n.dot((t[1] - t[0]).cross(p - t[0])) >= 0 &&
                           n.dot((t[2] - t[1]).cross(p - t[1])) >= 0 &&
                           n.dot((t[0] - t[2]).cross(p - t[2])) >= 0;
  if (over_inside) {
    const double height = n.dot(p - t[0]);
    return height * height / n2;
  }
  return std::min({SquaredDistanceToSegment(p, t[0], t[1]), SquaredDistanceToSegment(p, t[1], t[2]),
                   SquaredDistanceToSegment(p, t[2], t[0])});
}

Eigen::Matrix4d PlaneQuadric(const Eigen::Vector3d& n, const Eigen::Vector3d& p, double weight) {
  Eigen::Vector4d plane;
  plane << n, -n.dot(p);
  return weight * plane * plane.transpose();
}

bool Contains(const Eigen::Vector3i& t, int vertex) {
  return t[0] == vertex || t[1] == vertex || t[2] == vertex;
}

}  // namespace

EdgeCollapse::EdgeCollapse(std::vector<Eigen::Vector3d> vertices,
                           std::vector<Eigen::Vector3i> triangles, std::vector<bool> locked,
                           double length_weight)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      length_weight_(length_weight),
      alive_(triangles_.size(), true),
      locked_(std::move(locked)),
      boundary_(vertices_.size(), false),
      version_(vertices_.size(), 0),
      triangles_of_(vertices_.size()) {
  for (size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_of_[triangles_[t][k]].push_back(static_cast<int>(t));
  }
  AddQuadrics();
  AddTrackedPoints();
}

// Adds the planes of the faces, weighted by area. At open edges it also adds a plane perpendicular
// to the face, so that borders keep their place.
void EdgeCollapse::AddQuadrics() {
  quadrics_.assign(vertices_.size(), Eigen::Matrix4d::Zero());
  for (const Eigen::Vector3i& t : triangles_) {
    const Triangle corners{vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
    const Eigen::Vector3d area_vector = AreaVector(corners);
    const double area2 = area_vector.norm();
    if (area2 == 0) continue;
    const Eigen::Vector3d n = area_vector / area2;
    for (int k = 0; k < 3; ++k) quadrics_[t[k]] += PlaneQuadric(n, corners[0], area2);
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!IsBoundaryEdge(a, b)) continue;
      boundary_[a] = boundary_[b] = true;
      const Eigen::Vector3d edge = vertices_[b] - vertices_[a];
      const Eigen::Matrix4d upright =
          PlaneQuadric(edge.cross(n).normalized(), vertices_[a], edge.squaredNorm());
      quadrics_[a] += upright;
      quadrics_[b] += upright;
    }
  }
}

void EdgeCollapse::AddTrackedPoints() {
  tracked_of_triangle_.resize(triangles_.size());
  const auto track = [&](const Eigen::Vector3d& p, int triangle) {
    tracked_of_triangle_[triangle].push_back(static_cast<int>(tracked_.size()));
    tracked_.push_back(p);
  };
  for (size_t v = 0; v < vertices_.size(); ++v) {
    if (!triangles_of_[v].empty()) track(vertices_[v], triangles_of_[v].front());
  }
  for (size_t t = 0; t < triangles_.size(); ++t) {
    const Eigen::Vector3i& corners = triangles_[t];
    track((vertices_[corners[0]] + vertices_[corners[1]] + vertices_[corners[2]]) / 3,
          static_cast<int>(t));
    for (int k = 0; k < 3; ++k) {
      const int a = corners[k], b = corners[(k + 1) % 3];
      // Two triangles have each inner edge; only one of them adds its midpoint.
      if (a < b || IsBoundaryEdge(a, b)) {
        track(0.5 * (vertices_[a] + vertices_[b]), static_cast<int>(t));
      }
    }
  }
}

std::vector<int> EdgeCollapse::NeighborsOf(int vertex) const {
  std::vector<int> neighbors;
  for (const int t : triangles_of_[vertex]) {
    for (int k = 0; k < 3; ++k) {
      if (triangles_[t][k] != vertex) neighbors.push_back(triangles_[t][k]);
    }
  }
  std::sort(neighbors.begin(), neighbors.end());
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  return neighbors;
}

bool EdgeCollapse::IsBoundaryEdge(int a, int b) const {
  int count = 0;
  for (const int t : triangles_of_[a]) count += Contains(triangles_[t], b);
  return count != 2;
}

// Link condition: the opposite corners of the edge's triangles are the only common neighbours of
// its two ends. Locked vertices stay, and a boundary vertex moves only along the boundary.
bool EdgeCollapse::KeepsTopology(int from, int to) const {
  if (locked_[from]) return false;
  const bool boundary_edge = IsBoundaryEdge(from, to);
  if (boundary_[from] && !boundary_edge) return false;
  const std::vector<int> a = NeighborsOf(from), b = NeighborsOf(to);
  std::vector<int> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common.size() == (boundary_edge ? 1u : 2u);
}

EdgeCollapse::Candidate EdgeCollapse::MakeCandidate(int from, int to) const {
  const Eigen::Vector4d p = vertices_[to].homogeneous();
  const double error = p.dot((quadrics_[from] + quadrics_[to]) * p);
  const double length2 = (vertices_[to] - vertices_[from]).squaredNorm();
  const double cost = error + length_weight_ * length2 * length2;
  return {cost, from, to, version_[from], version_[to]};
}

bool EdgeCollapse::TryCollapse(int from, int to, double tolerance_m) {
  if (!KeepsTopology(from, to)) return false;
  std::vector<int> kept, points;
  std::vector<Triangle> moved;
  for (const int t : triangles_of_[from]) {
    points.insert(points.end(), tracked_of_triangle_[t].begin(), tracked_of_triangle_[t].end());
    if (Contains(triangles_[t], to)) continue;
    Triangle before, after;
    for (int k = 0; k < 3; ++k) {
      before[k] = vertices_[triangles_[t][k]];
      after[k] = triangles_[t][k] == from ? vertices_[to] : before[k];
    }
    const Eigen::Vector3d n0 = AreaVector(before), n1 = AreaVector(after);
    if (n0.dot(n1) < kMinNormalCosine * n0.norm() * n1.norm() || n1.isZero(0)) return false;
    kept.push_back(t);
    moved.push_back(after);
  }
  if (kept.empty()) return false;

  std::vector<size_t> nearest(points.size(), 0);
  for (size_t i = 0; i < points.size(); ++i) {
    double best = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < moved.size(); ++j) {
      const double distance = SquaredDistance(tracked_[points[i]], moved[j]);
      if (distance < best) best = distance, nearest[i] = j;
    }
    if (best > tolerance_m * tolerance_m) return false;
  }

  for (const int t : triangles_of_[from]) {
    tracked_of_triangle_[t].clear();
    if (!Contains(triangles_[t], to)) continue;
    alive_[t] = false;
    for (int k = 0; k < 3; ++k) {
      if (const int v = triangles_[t][k]; v != from) std::erase(triangles_of_[v], t);
    }
  }
  for (const int t : kept) {
    for (int k = 0; k < 3; ++k) {
      if (triangles_[t][k] == from) triangles_[t][k] = to;
    }
    triangles_of_[to].push_back(t);
  }
  triangles_of_[from].clear();
  for (size_t i = 0; i < points.size(); ++i) {
    tracked_of_triangle_[kept[nearest[i]]].push_back(points[i]);
  }
  quadrics_[to] += quadrics_[from];
  return true;
}

void EdgeCollapse::ReduceTo(double tolerance_m) {
  std::priority_queue<Candidate> queue;
  for (size_t t = 0; t < triangles_.size(); ++t) {
    if (!alive_[t]) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
      queue.push(MakeCandidate(a, b));
      if (IsBoundaryEdge(a, b)) queue.push(MakeCandidate(b, a));
    }
  }
  while (!queue.empty()) {
    const Candidate c = queue.top();
    queue.pop();
    if (c.from_version != version_[c.from] || c.to_version != version_[c.to]) continue;
    if (!TryCollapse(c.from, c.to, tolerance_m)) continue;
    ++version_[c.from];
    // Only edges at `to` change their cost. Edges between its neighbours may have become possible,
    // but the next call with a larger tolerance tests them again.
    ++version_[c.to];
    for (const int neighbor : NeighborsOf(c.to)) {
      queue.push(MakeCandidate(c.to, neighbor));
      queue.push(MakeCandidate(neighbor, c.to));
    }
  }
}

std::vector<Eigen::Vector3i> EdgeCollapse::Triangles() const {
  std::vector<Eigen::Vector3i> out;
  for (size_t t = 0; t < triangles_.size(); ++t) {
    if (alive_[t]) out.push_back(triangles_[t]);
  }
  return out;
}

}  // namespace pickbed::scenes
