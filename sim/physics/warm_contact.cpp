#include "sim/physics/warm_contact.h"

#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>

#include "sim/physics/pad_geometry.h"

namespace pickbed::sim {
namespace {

bool IsPolyhedron(int shape_type) {
  return shape_type == CONVEX_HULL_SHAPE_PROXYTYPE || shape_type == BOX_SHAPE_PROXYTYPE;
}

class WarmContacts : public btActivatingCollisionAlgorithm {
 public:
  WarmContacts(const btCollisionAlgorithmConstructionInfo& info,
               const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
               btConvexPenetrationDepthSolver& depth_solver)
      : btActivatingCollisionAlgorithm(info, first, second),
        depth_solver_(depth_solver),
        manifold_(info.m_manifold),
        owns_manifold_(info.m_manifold == nullptr) {
    if (owns_manifold_) {
      manifold_ =
          m_dispatcher->getNewManifold(first->getCollisionObject(), second->getCollisionObject());
    }
  }

  ~WarmContacts() override {
    if (owns_manifold_) m_dispatcher->releaseManifold(manifold_);
  }

  void processCollision(const btCollisionObjectWrapper* first,
                        const btCollisionObjectWrapper* second, const btDispatcherInfo& info,
                        btManifoldResult* result) override {
    const auto* shape_a = static_cast<const btConvexShape*>(first->getCollisionShape());
    const auto* shape_b = static_cast<const btConvexShape*>(second->getCollisionShape());
    const btTransform& X_WA = first->getWorldTransform();
    const btTransform& X_WB = second->getWorldTransform();
    const btScalar reach = shape_a->getMargin() + shape_b->getMargin() +
                           manifold_->getContactBreakingThreshold() +
                           result->m_closestPointDistanceThreshold;
    result->setPersistentManifold(manifold_);
    const int known = manifold_->getNumContacts();
    if (!StillSeparated(*shape_a, X_WA, *shape_b, X_WB, reach)) {
      btVoronoiSimplexSolver simplex_solver;
      btGjkPairDetector detector(shape_a, shape_b, &simplex_solver, &depth_solver_);
      detector.setCachedSeparatingAxis(X_WA.getBasis() * axis_A_);
      btGjkPairDetector::ClosestPointInput input;
      input.m_maximumDistanceSquared = reach * reach;
      input.m_transformA = X_WA;
      input.m_transformB = X_WB;
      detector.getClosestPoints(input, *result, info.m_debugDraw);
      const btVector3& axis_W = detector.getCachedSeparatingAxis();
      axis_A_ = axis_W * X_WA.getBasis();
      if (!(axis_A_.length2() > SIMD_EPSILON)) axis_A_ = btVector3(0, 1, 0);
      // Four existing contacts are kept, because new ones in their place would start without
      // impulses.
      if (known < MANIFOLD_CACHE_SIZE) {
        if (IsPad(*first)) AddPadFace(*first, *second, true, axis_W, *result);
        if (IsPad(*second)) AddPadFace(*second, *first, false, axis_W, *result);
      }
    }
    if (owns_manifold_) result->refreshContactPoints();
  }

  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;  // continuous collision detection is not used
  }

  void getAllContactManifolds(btManifoldArray& manifolds) override {
    if (owns_manifold_) manifolds.push_back(manifold_);
  }

 private:
  // Returns whether the gap between the pieces along the last axis, from B to A, is above `reach`.
  bool StillSeparated(const btConvexShape& shape_a, const btTransform& X_WA,
                      const btConvexShape& shape_b, const btTransform& X_WB, btScalar reach) const {
    const btVector3 axis_W = X_WA.getBasis() * axis_A_;
    const btVector3 p_A = shape_a.localGetSupportVertexWithoutMarginNonVirtual(-axis_A_);
    const btVector3 p_B =
        shape_b.localGetSupportVertexWithoutMarginNonVirtual(axis_W * X_WB.getBasis());
    const btScalar gap = axis_W.dot(X_WA(p_A) - X_WB(p_B));
    return gap > 0 && gap * gap > reach * reach * axis_A_.length2();
  }

  btConvexPenetrationDepthSolver& depth_solver_;
  btPersistentManifold* manifold_;
  const bool owns_manifold_;
  btVector3 axis_A_{0, 1, 0};
};

// Bullet allocates memory of the size of its own largest algorithm.
static_assert(sizeof(WarmContacts) <= sizeof(btConvexConvexAlgorithm));

}  // namespace

class WarmContactConfiguration::Maker : public btCollisionAlgorithmCreateFunc {
 public:
  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* first,
                                                 const btCollisionObjectWrapper* second) override {
    void* memory = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(WarmContacts));
    return new (memory) WarmContacts(info, first, second, depth_solver_);
  }

 private:
  btGjkEpaPenetrationDepthSolver depth_solver_;
};

WarmContactConfiguration::WarmContactConfiguration() : maker_(std::make_unique<Maker>()) {}
WarmContactConfiguration::~WarmContactConfiguration() = default;

btCollisionAlgorithmCreateFunc* WarmContactConfiguration::getCollisionAlgorithmCreateFunc(
    int type_a, int type_b) {
  const bool both_boxes = type_a == BOX_SHAPE_PROXYTYPE && type_b == BOX_SHAPE_PROXYTYPE;
  if (IsPolyhedron(type_a) && IsPolyhedron(type_b) && !both_boxes) return maker_.get();
  return btDefaultCollisionConfiguration::getCollisionAlgorithmCreateFunc(type_a, type_b);
}

}  // namespace pickbed::sim
