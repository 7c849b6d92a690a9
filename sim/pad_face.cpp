#include <BulletCollision/CollisionShapes/btConvexPolyhedron.h>
#include <BulletCollision/NarrowPhaseCollision/btPolyhedralContactClipping.h>

#include <cmath>

#include "sim/bullet_bridge.h"
#include "sim/pad_face_impl.h"

namespace pickbed {
namespace {

// Bullet's own list of faces, made when a piece is first asked for it.
const btConvexPolyhedron& FacesOf(const btConvexHullShape& hull) {
  if (hull.getConvexPolyhedron() == nullptr) {
    const_cast<btConvexHullShape&>(hull).initializePolyhedralFeatures();
  }
  return *hull.getConvexPolyhedron();
}

// The face that looks most along a direction; null when none looks that way within the pads' angle.
const btFace* FaceAlong(const btConvexPolyhedron& faces, const btVector3& direction) {
  const btFace* best = nullptr;
  btScalar most = kPadNormal;
  for (int i = 0; i < faces.m_faces.size(); ++i) {
    const btScalar* plane = faces.m_faces[i].m_plane;
    const btScalar cosine = btVector3(plane[0], plane[1], plane[2]).dot(direction);
    if (cosine <= most) continue;
    most = cosine;
    best = &faces.m_faces[i];
  }
  return best;
}

}  // namespace

bool IsPad(const btCollisionObjectWrapper& body) {
  const btBroadphaseProxy* proxy = body.getCollisionObject()->getBroadphaseHandle();
  return proxy != nullptr && proxy->m_collisionFilterGroup == kFingerGroup;
}

void AddPadFace(const btCollisionObjectWrapper& pad, const btCollisionObjectWrapper& hull,
                bool pad_is_first, const btVector3& axis_W, btManifoldResult& result) {
  const btTransform& X_WP = pad.getWorldTransform();
  const btVector3 axis_P = axis_W * X_WP.getBasis();
  if (std::abs(axis_P.x()) < kPadNormal * axis_P.length()) return;
  const btTransform X_PH = X_WP.inverse() * hull.getWorldTransform();
  // The pieces' own direction, not the axis': its sign says nothing of who is where.
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
  // As many as Bullet keeps of two pieces: those furthest out towards the pad's four corners.
  for (const btScalar y : {-1.0, 1.0}) {
    for (const btScalar z : {-1.0, 1.0}) {
      btScalar unused;
      const btVector3 outward(0, y * half.z(), z * half.y());
      btVector3 place_P = corners[outward.maxDot(&corners[0], corners.size(), unused)];
      const btScalar gap = side * place_P.x() - half.x() - shape.getMargin();
      if (gap > reach) continue;
      // On the second of the two.
      place_P.setX(pad_is_first ? place_P.x() - side * shape.getMargin() : side * half.x());
      result.addContactPoint(normal_W, X_WP * place_P, gap);
    }
  }
}

}  // namespace pickbed
