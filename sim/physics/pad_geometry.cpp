#include "sim/physics/pad_geometry.h"

#include <BulletCollision/CollisionShapes/btConvexPolyhedron.h>
#include <BulletCollision/NarrowPhaseCollision/btPolyhedralContactClipping.h>

#include <algorithm>
#include <cmath>

#include "sim/physics/bullet_types.h"

namespace pickbed::sim {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Returns the integral of the distance to the origin over the triangle (origin, a, b). In polar
// coordinates about the foot of the perpendicular from the origin to ab, it is h^3 / 3 times the
// integral of sec^3.
double IntegralOfDistance(const Vector2d& a, const Vector2d& b) {
  const double length = (b - a).norm();
  const double h = length > 0 ? Cross(a, b) / length : 0;
  if (!(h > 0)) return 0;
  const Vector2d along = (b - a) / length;
  const auto primitive = [](double t) {  // of sec^3, with t = tan
    return 0.5 * (t * std::sqrt(1 + t * t) + std::asinh(t));
  };
  return h * h * h / 3 * (primitive(b.dot(along) / h) - primitive(a.dot(along) / h));
}

}  // namespace

std::vector<Vector2d> ConvexOutline(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vector2d> hull(2 * points.size());
  size_t n = 0;
  const auto add = [&](const Vector2d& p, size_t minimum) {
    while (n >= minimum && Cross(hull[n - 1] - hull[n - 2], p - hull[n - 2]) <= 0) --n;
    hull[n++] = p;
  };
  for (const Vector2d& p : points) add(p, 2);
  const size_t upper = n + 1;
  for (size_t i = points.size() - 1; i-- > 0;) add(points[i], upper);
  hull.resize(n - 1);
  return hull;
}

std::vector<Vector2d> ClippedToRectangle(std::vector<Vector2d> outline, const Vector2d& half) {
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto inside = [&](const Vector2d& p) { return half[axis] - side * p[axis]; };
      std::vector<Vector2d> kept;
      for (size_t i = 0; i < outline.size(); ++i) {
        const Vector2d& a = outline[i];
        const Vector2d& b = outline[(i + 1) % outline.size()];
        const double in_a = inside(a), in_b = inside(b);
        if (in_a >= 0) kept.push_back(a);
        if ((in_a > 0 && in_b < 0) || (in_a < 0 && in_b > 0)) {
          kept.push_back(a + in_a / (in_a - in_b) * (b - a));
        }
      }
      outline = std::move(kept);
    }
  }
  return outline;
}

EvenPressure PressureOn(const std::vector<Vector2d>& outline) {
  const Vector2d& origin = outline.front();
  const size_t count = outline.size();
  double area = 0, span = 0;
  Vector2d moment = Vector2d::Zero(), center = origin;
  for (size_t i = 0; i < count; ++i) {
    const Vector2d a = outline[i] - origin, b = outline[(i + 1) % count] - origin;
    area += 0.5 * Cross(a, b);
    moment += 0.5 * Cross(a, b) * (a + b) / 3;
    for (const Vector2d& other : outline) {
      if ((outline[i] - other).norm() <= span) continue;
      span = (outline[i] - other).norm();
      center = 0.5 * (outline[i] + other);
    }
  }
  constexpr double kThin = 1e-3;  // an outline this much narrower than long is a line
  if (area <= kThin * span * span) return {center, 0.25 * span};
  const Vector2d centroid = origin + moment / area;
  double sum = 0;
  for (size_t i = 0; i < count; ++i) {
    sum += IntegralOfDistance(outline[i] - centroid, outline[(i + 1) % count] - centroid);
  }
  return {centroid, sum / area};
}

namespace {

// Returns Bullet's list of faces, which is created at the first request for a piece.
const btConvexPolyhedron& FacesOf(const btConvexHullShape& hull) {
  if (hull.getConvexPolyhedron() == nullptr) {
    const_cast<btConvexHullShape&>(hull).initializePolyhedralFeatures();
  }
  return *hull.getConvexPolyhedron();
}

// Returns the face whose normal is nearest to a direction; null if all are outside the pad angle.
const btFace* FaceAlong(const btConvexPolyhedron& faces, const btVector3& direction) {
  const btFace* best = nullptr;
  btScalar maximum = kPadNormal;
  for (int i = 0; i < faces.m_faces.size(); ++i) {
    const btScalar* plane = faces.m_faces[i].m_plane;
    const btScalar cosine = btVector3(plane[0], plane[1], plane[2]).dot(direction);
    if (cosine <= maximum) continue;
    maximum = cosine;
    best = &faces.m_faces[i];
  }
  return best;
}

}  // namespace

bool IsPad(const btCollisionObjectWrapper& body) {
  const btBroadphaseProxy* proxy = body.getCollisionObject()->getBroadphaseHandle();
  return proxy != nullptr && proxy->m_collisionFilterGroup == kDrivenHandGroup;
}

void AddPadFace(const btCollisionObjectWrapper& pad, const btCollisionObjectWrapper& hull,
                bool pad_is_first, const btVector3& axis_W, btManifoldResult& result) {
  const btTransform& X_WP = pad.getWorldTransform();
  const btVector3 axis_P = axis_W * X_WP.getBasis();
  if (std::abs(axis_P.x()) < kPadNormal * axis_P.length()) return;
  const btTransform X_PH = X_WP.inverse() * hull.getWorldTransform();
  // The direction from the pad to the piece, not the axis: the axis' sign does not define the order
  // of the two.
  const auto& shape = *static_cast<const btConvexHullShape*>(hull.getCollisionShape());
  const btConvexPolyhedron& faces = FacesOf(shape);
  const btScalar side = (X_PH * faces.m_localCenter).x() < 0 ? -1 : 1;
  const btFace* face = FaceAlong(faces, btVector3(-side, 0, 0) * X_PH.getBasis());
  if (face == nullptr) return;

  btVertexArray corners, clipped;
  for (int i = 0; i < face->m_indices.size(); ++i) {
    corners.push_back(X_PH * faces.m_vertices[face->m_indices[i]]);
  }
  const btVector3 half =
      static_cast<const btBoxShape*>(pad.getCollisionShape())->getHalfExtentsWithMargin();
  for (const int across : {1, 2}) {
    for (const btScalar edge : {-1.0, 1.0}) {
      btVector3 outward(0, 0, 0);
      outward[across] = edge;
      clipped.resize(0);
      btPolyhedralContactClipping::clipFace(corners, clipped, outward, -half[across]);
      corners = clipped;
    }
  }
  if (corners.size() == 0) return;
  const btVector3 normal_W = X_WP.getBasis().getColumn(0) * (pad_is_first ? -side : side);
  const btScalar reach = result.getPersistentManifold()->getContactBreakingThreshold();
  // Four points, as Bullet keeps for two pieces: those farthest out towards the pad's corners.
  for (const btScalar y : {-1.0, 1.0}) {
    for (const btScalar z : {-1.0, 1.0}) {
      btScalar unused;
      const btVector3 outward(0, y * half.z(), z * half.y());
      btVector3 place_P = corners[outward.maxDot(&corners[0], corners.size(), unused)];
      const btScalar gap = side * place_P.x() - half.x() - shape.getMargin();
      if (gap > reach) continue;
      // Bullet's contact position is on the second body.
      place_P.setX(pad_is_first ? place_P.x() - side * shape.getMargin() : side * half.x());
      result.addContactPoint(normal_W, X_WP * place_P, gap);
    }
  }
}

}  // namespace pickbed::sim
