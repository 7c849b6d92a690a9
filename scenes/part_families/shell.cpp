#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "scenes/base/math.h"
#include "scenes/part_families/shapes.h"

namespace pickbed::scenes {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

std::array<int64_t, 3> Rounded(const Vector3d& v, double grid) {
  return {std::llround(v.x() / grid), std::llround(v.y() / grid), std::llround(v.z() / grid)};
}

// Returns Newell's normal of a nearly flat loop; its length is twice the area.
Vector3d AreaNormal(const Loop& loop) {
  Vector3d sum = Vector3d::Zero();
  for (size_t i = 0; i < loop.size(); ++i) {
    sum += (loop[i] - loop[0]).cross(loop[(i + 1) % loop.size()] - loop[0]);
  }
  return sum;
}

double CornerAngle(const Corners& t, int k) {
  const Vector3d a = t[(k + 1) % 3] - t[k], b = t[(k + 2) % 3] - t[k];
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

void ShellBuilder::Triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  triangles_.push_back({a, b, c});
}

void ShellBuilder::Face(const Loop& outer, const std::vector<Loop>& holes) {
  const Vector3d normal = AreaNormal(outer).normalized();
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const auto flat = [&](const Loop& loop) {
    Outline outline;
    for (const Vector3d& p : loop) outline.emplace_back(u.dot(p), v.dot(p));
    return outline;
  };
  Loop points = outer;
  std::vector<Outline> flat_holes;
  for (const Loop& hole : holes) {
    flat_holes.push_back(flat(hole));
    points.insert(points.end(), hole.begin(), hole.end());
  }
  for (const Eigen::Vector3i& t : TriangulatePolygon(flat(outer), flat_holes)) {
    Triangle(points[t[0]], points[t[1]], points[t[2]]);
  }
}

void ShellBuilder::Quad(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                        const Vector3d& d) {
  // The tolerance gives all diagonals in a band of equal quads the same direction.
  constexpr double kClearlyShorter = 0.999;
  if ((b - d).norm() < kClearlyShorter * (a - c).norm()) {
    Triangle(a, b, d);
    Triangle(b, c, d);
  } else {
    Triangle(a, b, c);
    Triangle(a, c, d);
  }
}

void ShellBuilder::Band(const Loop& lower, const Loop& upper) {
  const size_t n = lower.size();
  for (size_t i = 0; i < n; ++i) {
    const size_t next = (i + 1) % n;
    Quad(lower[i], lower[next], upper[next], upper[i]);
  }
}

void ShellBuilder::Net(const std::vector<Loop>& rows) {
  for (size_t r = 0; r + 1 < rows.size(); ++r) {
    for (size_t c = 0; c + 1 < rows[r].size(); ++c) {
      Quad(rows[r][c], rows[r][c + 1], rows[r + 1][c + 1], rows[r + 1][c]);
    }
  }
}

void ShellBuilder::Prism(const Outline& outer, const std::vector<Outline>& holes, double z0,
                         double z1) {
  Outline ccw = outer;
  if (SignedArea(ccw) < 0) std::reverse(ccw.begin(), ccw.end());
  const Loop bottom = AtHeight(ccw, z0), top = AtHeight(ccw, z1);
  std::vector<Loop> bottom_holes, top_holes;
  for (Outline hole : holes) {
    if (SignedArea(hole) < 0) std::reverse(hole.begin(), hole.end());
    bottom_holes.push_back(AtHeight(hole, z0));
    top_holes.push_back(AtHeight(hole, z1));
    Band(top_holes.back(), bottom_holes.back());
  }
  Face(top, top_holes);
  Face(Reversed(bottom), bottom_holes);
  Band(bottom, top);
}

void ShellBuilder::Revolve(const Outline& profile, int count) {
  Face(Reversed(Circle(profile[1].x(), count, profile[1].y())));
  for (size_t i = 1; i + 2 < profile.size(); ++i) {
    Band(Circle(profile[i].x(), count, profile[i].y()),
         Circle(profile[i + 1].x(), count, profile[i + 1].y()));
  }
  const Vector2d& last = profile[profile.size() - 2];
  Face(Circle(last.x(), count, last.y()));
}

void ShellBuilder::RevolveRing(const Outline& profile, int count) {
  for (size_t i = 0; i < profile.size(); ++i) {
    const Vector2d& a = profile[i];
    const Vector2d& b = profile[(i + 1) % profile.size()];
    Band(Circle(a.x(), count, a.y()), Circle(b.x(), count, b.y()));
  }
}

void ShellBuilder::Transform(const Pose& X_AB) {
  for (Corners& t : triangles_) {
    for (Vector3d& p : t) p = X_AB * p;
  }
}

TriangleMesh ShellBuilder::Build(double crease_deg) const {
  constexpr double kSamePoint = 1e-6;   // mm
  constexpr double kSameNormal = 1e-5;  // rounding of the components of a unit vector
  struct Corner {
    Vector3d normal;
    double angle;
  };
  std::map<std::array<int64_t, 3>, std::vector<Corner>> corners;  // by place
  std::vector<Vector3d> face_normals;
  for (const Corners& t : triangles_) {
    face_normals.push_back((t[1] - t[0]).cross(t[2] - t[0]).normalized());
    for (int k = 0; k < 3; ++k) {
      corners[Rounded(t[k], kSamePoint)].push_back({face_normals.back(), CornerAngle(t, k)});
    }
  }
  const double flat_cosine = std::cos(Radians(crease_deg));
  TriangleMesh mesh;
  std::map<std::array<int64_t, 6>, int> indices;  // by place and normal
  for (size_t f = 0; f < triangles_.size(); ++f) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      const auto place = Rounded(triangles_[f][k], kSamePoint);
      Vector3d sum = Vector3d::Zero();
      for (const Corner& corner : corners[place]) {
        if (corner.normal.dot(face_normals[f]) > flat_cosine) sum += corner.angle * corner.normal;
      }
      const Vector3d normal = sum.normalized();
      const auto n = Rounded(normal, kSameNormal);
      const std::array<int64_t, 6> key = {place[0], place[1], place[2], n[0], n[1], n[2]};
      const auto [it, fresh] = indices.try_emplace(key, static_cast<int>(mesh.vertices.size()));
      if (fresh) {
        mesh.vertices.push_back(triangles_[f][k]);
        mesh.normals.push_back(normal);
      }
      triangle[k] = it->second;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace pickbed::scenes
