#include "scenes/geometry/polygon_triangulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3i;
using Ring = std::vector<int>;  // indices of points; a bridge to a hole repeats its two ends

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double Turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) { return Cross(b - a, c - b); }

bool SegmentsMeet(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  if (a == c || a == d || b == c || b == d) return false;
  const double abc = Turn(a, b, c), abd = Turn(a, b, d), cda = Turn(c, d, a), cdb = Turn(c, d, b);
  return abc * abd <= 0 && cda * cdb <= 0;
}

Ring Wound(int first, const Outline& outline, bool counter_clockwise) {
  Ring ring(outline.size());
  std::iota(ring.begin(), ring.end(), first);
  if ((SignedArea(outline) > 0) != counter_clockwise) std::reverse(ring.begin(), ring.end());
  return ring;
}

bool SegmentsCross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return Turn(a, b, c) * Turn(a, b, d) < 0 && Turn(c, d, a) * Turn(c, d, b) < 0;
}

bool RingsCross(const Ring& first, const Ring& second, const Outline& points) {
  for (size_t i = 0; i < first.size(); ++i) {
    const Vector2d& a = points[first[i]];
    const Vector2d& b = points[first[(i + 1) % first.size()]];
    for (size_t k = 0; k < second.size(); ++k) {
      const Vector2d& c = points[second[k]];
      if (SegmentsCross(a, b, c, points[second[(k + 1) % second.size()]])) return true;
    }
  }
  return false;
}

// Returns whether `p` is inside the ring, by the parity of the crossings of a ray along +x.
bool Holds(const Ring& ring, const Vector2d& p, const Outline& points) {
  bool inside = false;
  for (size_t i = 0; i < ring.size(); ++i) {
    const Vector2d& a = points[ring[i]];
    const Vector2d& b = points[ring[(i + 1) % ring.size()]];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const double x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > p.x()) inside = !inside;
  }
  return inside;
}

void RequireSimple(const Ring& outer, const std::vector<Ring>& holes, const Outline& points) {
  std::vector<Ring> rings = holes;
  rings.push_back(outer);
  for (const Ring& ring : rings) {
    if (ring.size() < 3) throw std::logic_error("polygon: an outline has less than three points");
  }
  for (size_t i = 0; i < rings.size(); ++i) {
    for (size_t k = i; k < rings.size(); ++k) {
      if (RingsCross(rings[i], rings[k], points)) throw std::logic_error("polygon: outlines cross");
    }
  }
  for (const Ring& hole : holes) {
    if (!Holds(outer, points[hole[0]], points)) {
      throw std::logic_error("polygon: a hole is outside of its outline");
    }
  }
}

bool BridgeIsFree(const Vector2d& a, const Vector2d& b, const std::vector<Ring>& rings,
                  const Outline& points) {
  for (const Ring& ring : rings) {
    for (size_t i = 0; i < ring.size(); ++i) {
      const Vector2d& c = points[ring[i]];
      const Vector2d& d = points[ring[(i + 1) % ring.size()]];
      if (SegmentsMeet(a, b, c, d)) return false;
    }
  }
  return true;
}

// Joins `ring` and `hole` along the shortest free line between two of their points. `obstacles` are
// all rings that the line must not cross.
Ring Bridged(const Ring& ring, const Ring& hole, const std::vector<Ring>& obstacles,
             const Outline& points) {
  double best = std::numeric_limits<double>::infinity();
  size_t best_ring = 0, best_hole = 0;
  for (size_t i = 0; i < ring.size(); ++i) {
    for (size_t k = 0; k < hole.size(); ++k) {
      const Vector2d& a = points[ring[i]];
      const Vector2d& b = points[hole[k]];
      const double distance = (a - b).squaredNorm();
      if (distance < best && BridgeIsFree(a, b, obstacles, points)) {
        best = distance;
        best_ring = i;
        best_hole = k;
      }
    }
  }
  if (!std::isfinite(best)) throw std::logic_error("polygon: a hole cannot be reached");
  Ring out(ring.begin(), ring.begin() + best_ring + 1);
  for (size_t k = 0; k <= hole.size(); ++k) out.push_back(hole[(best_hole + k) % hole.size()]);
  out.insert(out.end(), ring.begin() + best_ring, ring.end());
  return out;
}

double SmallestAngle(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const double area = Cross(b - a, c - a);
  const double angle_a = std::atan2(area, (b - a).dot(c - a));
  const double angle_b = std::atan2(area, (c - b).dot(a - b));
  return std::min({angle_a, angle_b, M_PI - angle_a - angle_b});
}

bool IsEar(const Ring& ring, size_t i, const Outline& points) {
  const size_t n = ring.size();
  const Vector2d& a = points[ring[(i + n - 1) % n]];
  const Vector2d& b = points[ring[i]];
  const Vector2d& c = points[ring[(i + 1) % n]];
  const double tolerance = 1e-12 * ((b - a).squaredNorm() + (c - b).squaredNorm());
  if (Turn(a, b, c) <= tolerance) return false;
  for (int index : ring) {
    const Vector2d& p = points[index];
    if (p == a || p == b || p == c) continue;
    if (Turn(a, b, p) >= -tolerance && Turn(b, c, p) >= -tolerance && Turn(c, a, p) >= -tolerance) {
      return false;
    }
  }
  return true;
}

std::vector<Vector3i> ClipEars(Ring ring, const Outline& points) {
  std::vector<Vector3i> triangles;
  while (ring.size() > 3) {
    const size_t n = ring.size();
    double best = -1;
    size_t ear = 0;
    for (size_t i = 0; i < n; ++i) {
      const double angle =
          SmallestAngle(points[ring[(i + n - 1) % n]], points[ring[i]], points[ring[(i + 1) % n]]);
      if (angle > best && IsEar(ring, i, points)) {
        best = angle;
        ear = i;
      }
    }
    if (best < 0) throw std::logic_error("polygon: no ear left to clip");
    triangles.emplace_back(ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]);
    ring.erase(ring.begin() + ear);
  }
  triangles.emplace_back(ring[0], ring[1], ring[2]);
  return triangles;
}

struct EdgeSide {
  int triangle;
  int apex;  // corner opposite to the edge
};

// Returns whether diagonal (a, b) of the quad a-d-b-c is to be replaced by (c, d). This is the case
// if the quad is convex and the circle through a, b, c contains d.
bool WantsFlip(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const double scale = (a - b).squaredNorm();
  if (Turn(c, d, b) < 1e-9 * scale || Turn(d, c, a) < 1e-9 * scale) return false;  // not convex
  const double angle_c = std::atan2(std::abs(Cross(a - c, b - c)), (a - c).dot(b - c));
  const double angle_d = std::atan2(std::abs(Cross(a - d, b - d)), (a - d).dot(b - d));
  return angle_c + angle_d > M_PI + 1e-9;
}

bool FlipOnce(const Outline& points, std::vector<Vector3i>& triangles) {
  std::map<std::pair<int, int>, std::array<EdgeSide, 2>> edges;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = triangles[t][k], b = triangles[t][(k + 1) % 3], c = triangles[t][(k + 2) % 3];
      auto [it, fresh] =
          edges.try_emplace(std::minmax(a, b), std::array<EdgeSide, 2>{EdgeSide{-1, -1}, {-1, -1}});
      it->second[a < b ? 0 : 1] = {t, c};  // side 0 has the edge from the low to the high index
    }
  }
  std::vector<bool> touched(triangles.size(), false);
  bool flipped = false;
  for (const auto& [edge, side] : edges) {
    if (side[0].triangle < 0 || side[1].triangle < 0) continue;
    if (touched[side[0].triangle] || touched[side[1].triangle]) continue;
    const auto [a, b] = edge;
    const int c = side[0].apex, d = side[1].apex;
    if (!WantsFlip(points[a], points[b], points[c], points[d])) continue;
    triangles[side[0].triangle] = {c, d, b};
    triangles[side[1].triangle] = {d, c, a};
    touched[side[0].triangle] = touched[side[1].triangle] = true;
    flipped = true;
  }
  return flipped;
}

}  // namespace

double SignedArea(const Outline& outline) {
  double twice = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    twice += Cross(outline[i], outline[(i + 1) % outline.size()]);
  }
  return 0.5 * twice;
}

std::vector<Vector3i> TriangulatePolygon(const Outline& outer, const std::vector<Outline>& holes) {
  Outline points = outer;
  Ring ring = Wound(0, outer, true);
  std::vector<Ring> hole_rings;
  for (const Outline& hole : holes) {
    hole_rings.push_back(Wound(static_cast<int>(points.size()), hole, false));
    points.insert(points.end(), hole.begin(), hole.end());
  }
  RequireSimple(ring, hole_rings, points);
  for (size_t h = 0; h < hole_rings.size(); ++h) {
    std::vector<Ring> obstacles(hole_rings.begin() + h, hole_rings.end());
    obstacles.push_back(ring);
    ring = Bridged(ring, hole_rings[h], obstacles, points);
  }
  std::vector<Vector3i> triangles = ClipEars(std::move(ring), points);
  constexpr int kMaxPasses = 200;  // flips terminate in theory; rounding could cause a loop
  for (int pass = 0; pass < kMaxPasses && FlipOnce(points, triangles); ++pass) {
  }
  return triangles;
}

}  // namespace pickbed::scenes
