#include "scenes/part_families/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/base/math.h"

namespace pickbed::scenes {

using Eigen::Vector2d;
using Eigen::Vector3d;

Loop Circle(double radius, int count, double z, double phase_rad) {
  return AtHeight(CircleOutline(Vector2d::Zero(), radius, count, phase_rad), z);
}

Outline Arc(const Vector2d& center, double radius, double begin_rad, double end_rad, int segments) {
  Outline arc;
  for (int i = 0; i <= segments; ++i) {
    const double angle = begin_rad + (end_rad - begin_rad) * i / segments;
    arc.push_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return arc;
}

Outline CircleOutline(const Vector2d& center, double radius, int count, double phase_rad) {
  Outline circle = Arc(center, radius, phase_rad, phase_rad + 2 * M_PI, count);
  circle.pop_back();
  return circle;
}

Loop AtHeight(const Outline& outline, double z) {
  Loop loop;
  for (const Vector2d& p : outline) loop.emplace_back(p.x(), p.y(), z);
  return loop;
}

Loop Moved(const Loop& loop, const Pose& X_AB) {
  Loop moved;
  for (const Vector3d& p : loop) moved.push_back(X_AB * p);
  return moved;
}

Loop Reversed(const Loop& loop) { return Loop(loop.rbegin(), loop.rend()); }

Pose Frame(const Vector3d& x_axis, const Vector3d& z_axis, const Vector3d& origin) {
  Pose X = Pose::Identity();
  X.linear().col(0) = x_axis;
  X.linear().col(1) = z_axis.cross(x_axis);
  X.linear().col(2) = z_axis;
  X.translation() = origin;
  return X;
}

ConvexPiece BoxPiece(const Vector3d& min, const Vector3d& max) {
  const Outline base = {
      {min.x(), min.y()}, {max.x(), min.y()}, {max.x(), max.y()}, {min.x(), max.y()}};
  return PrismPiece(base, min.z(), max.z());
}

ConvexPiece HullPiece(const Loop& points) {
  constexpr double kFlat = 1e-6, kSliver = 1e-4;  // mm, mm2
  const size_t n = points.size();
  std::vector<bool> corner(n, false);
  // Three points span a face of the hull if all points are on one side of their plane. Pieces have
  // few points, so testing all triples is fast enough.
  for (size_t a = 0; a < n; ++a) {
    for (size_t b = a + 1; b < n; ++b) {
      for (size_t c = b + 1; c < n; ++c) {
        const Vector3d normal = (points[b] - points[a]).cross(points[c] - points[a]);
        if (normal.norm() < kSliver) continue;
        double low = 0, high = 0;
        for (const Vector3d& p : points) {
          const double height = normal.dot(p - points[a]) / normal.norm();
          low = std::min(low, height);
          high = std::max(high, height);
        }
        if (low > -kFlat || high < kFlat) corner[a] = corner[b] = corner[c] = true;
      }
    }
  }
  ConvexPiece piece;
  for (size_t i = 0; i < n; ++i) {
    if (corner[i]) piece.vertices_O.push_back(points[i]);
  }
  return piece;
}

ConvexPiece PrismPiece(const Outline& convex, double z0, double z1) {
  return LoftPiece(AtHeight(convex, z0), AtHeight(convex, z1));
}

ConvexPiece LoftPiece(const Loop& lower, const Loop& upper) {
  ConvexPiece piece{lower};
  piece.vertices_O.insert(piece.vertices_O.end(), upper.begin(), upper.end());
  return piece;
}

double BalancedRadius(double radius, int corners) {
  return 2 * radius / (1 + std::cos(M_PI / corners));
}

ConvexPiece DiscPiece(double lower_radius, double upper_radius, double z0, double z1, int count) {
  return LoftPiece(Circle(BalancedRadius(lower_radius, count), count, z0),
                   Circle(BalancedRadius(upper_radius, count), count, z1));
}

std::vector<ConvexPiece> RingPieces(const RingSpec& spec) {
  const double step = spec.sweep_rad / spec.sectors;
  const double inner = 2 * spec.inner_radius / (1 + std::cos(step / 2));
  std::vector<ConvexPiece> pieces;
  for (int i = 0; i < spec.sectors; ++i) {
    const double begin = spec.begin_rad + i * step;
    Outline sector =
        Arc(Vector2d::Zero(), spec.outer_radius, begin, begin + step, spec.outer_segments);
    const Outline chord = Arc(Vector2d::Zero(), inner, begin + step, begin, 1);
    sector.insert(sector.end(), chord.begin(), chord.end());
    pieces.push_back(PrismPiece(sector, spec.z0, spec.z1));
  }
  return pieces;
}

void MovePieces(const Pose& X_AB, std::vector<ConvexPiece>& pieces) {
  for (ConvexPiece& piece : pieces) piece.vertices_O = Moved(piece.vertices_O, X_AB);
}

void AppendPieces(const std::vector<ConvexPiece>& more, std::vector<ConvexPiece>& pieces) {
  pieces.insert(pieces.end(), more.begin(), more.end());
}

Pose Turn(const Vector3d& axis, double angle_deg) {
  return Pose(Eigen::AngleAxisd(Radians(angle_deg), axis.normalized()));
}

std::vector<Pose> CyclicZ(int order) {
  std::vector<Pose> turns;
  for (int i = 1; i < order; ++i) turns.push_back(Turn(Vector3d::UnitZ(), 360.0 * i / order));
  return turns;
}

std::vector<Pose> DihedralZ(int order) {
  std::vector<Pose> turns = CyclicZ(order);
  for (int i = 0; i < order; ++i) {
    const double angle = M_PI * i / order;
    turns.push_back(Turn({std::cos(angle), std::sin(angle), 0}, 180));
  }
  return turns;
}

FamilyObject FinishObject(const TriangleMesh& mesh_mm, const std::vector<ConvexPiece>& pieces_mm,
                          const SymmetrySet& symmetries_mm, const FamilyMaterial& material) {
  constexpr double kMeters = 1e-3;
  constexpr double kGrid_m = 1e-9;  // rounding removes differences between compilers
  const Vector3d center = MeshBounds(mesh_mm).center();
  const auto to_meters = [&](const Vector3d& p) -> Vector3d {
    const Vector3d steps = ((p - center) * (kMeters / kGrid_m)).array().round();
    return steps * kGrid_m;
  };
  FamilyObject object;
  object.mesh_O = mesh_mm;
  object.mesh_O.base_color = material.color;
  for (Vector3d& p : object.mesh_O.vertices) p = to_meters(p);
  object.convex_pieces_O = pieces_mm;
  for (ConvexPiece& piece : object.convex_pieces_O) {
    for (Vector3d& p : piece.vertices_O) p = to_meters(p);
  }
  for (const Pose& X_mm : symmetries_mm.discrete_O) {
    Pose X_O = X_mm;
    X_O.translation() = (X_mm * center - center) * kMeters;
    object.symmetries_O.discrete_O.push_back(X_O);
  }
  for (const ContinuousSymmetry& s : symmetries_mm.continuous_O) {
    // The offset is the point of the axis that is nearest to the new origin.
    const Vector3d from_center = s.offset_O - center;
    const Vector3d offset = from_center - s.axis_O * s.axis_O.dot(from_center);
    object.symmetries_O.continuous_O.push_back({s.axis_O, offset * kMeters});
  }
  object.density_kgpm3 = material.density_kgpm3;
  object.friction = material.friction;
  return object;
}

}  // namespace pickbed::scenes
