#include "sim/physics/contact_reuse.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Boxes in a row on a fixed floor, each in contact with the floor and with its neighbors.
struct RowOfBoxes {
  btDefaultCollisionConfiguration configuration;
  ReusingDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btBoxShape floor_shape{{20, 20, 1}}, box_shape{{0.5, 0.5, 0.5}};
  btRigidBody floor{0, nullptr, &floor_shape};
  std::vector<std::unique_ptr<btRigidBody>> boxes;

  explicit RowOfBoxes(int count) {
    world.setGravity({0, 0, -10});
    floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), {0, 0, -1}));
    world.addRigidBody(&floor);
    for (int i = 0; i < count; ++i) {
      boxes.push_back(std::make_unique<btRigidBody>(1, nullptr, &box_shape, btVector3(1, 1, 1)));
      boxes.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), {1.0 * i, 0, 0.5}));
      world.addRigidBody(boxes.back().get());
    }
  }
  ~RowOfBoxes() {
    for (const auto& box : boxes) world.removeRigidBody(box.get());
    world.removeRigidBody(&floor);
  }

  std::vector<const btPersistentManifold*> Manifolds(bool only_awake) {
    dispatcher.ShowOnlyAwake(only_awake);
    std::vector<const btPersistentManifold*> manifolds(dispatcher.getNumManifolds());
    for (size_t i = 0; i < manifolds.size(); ++i) {
      manifolds[i] = dispatcher.getManifoldByIndexInternal(static_cast<int>(i));
    }
    dispatcher.ShowOnlyAwake(false);
    return manifolds;
  }

  std::vector<const btPersistentManifold*> AwakeManifolds() {
    std::vector<const btPersistentManifold*> awake;
    for (const btPersistentManifold* manifold : Manifolds(false)) {
      const int first = manifold->getBody0()->getActivationState();
      const int second = manifold->getBody1()->getActivationState();
      if (first != ISLAND_SLEEPING || second != ISLAND_SLEEPING) awake.push_back(manifold);
    }
    return awake;
  }
};

TEST(ReusingDispatcher, ShowsTheManifoldsOfAwakeBodiesInBulletsOrder) {
  RowOfBoxes row(12);
  Rng rng(1);
  row.world.stepSimulation(0.01, 0);
  ASSERT_EQ(row.Manifolds(false).size(), 12u + 11u);
  while (row.boxes.size() > 1) {
    for (const auto& box : row.boxes) {
      box->forceActivationState(rng.Index(3) == 0 ? ACTIVE_TAG : ISLAND_SLEEPING);
    }
    EXPECT_EQ(row.Manifolds(true), row.AwakeManifolds());
    // Bullet fills the gaps of the removed manifolds with the last ones.
    const int removed = rng.Index(static_cast<int>(row.boxes.size()));
    row.world.removeRigidBody(row.boxes[removed].get());
    row.boxes.erase(row.boxes.begin() + removed);
    EXPECT_EQ(row.Manifolds(true), row.AwakeManifolds());
  }
}

TEST(ReusingDispatcher, ShowsNothingWhenAllSleep) {
  RowOfBoxes row(3);
  row.world.stepSimulation(0.01, 0);
  for (const auto& box : row.boxes) box->forceActivationState(ISLAND_SLEEPING);
  EXPECT_TRUE(row.Manifolds(true).empty());
  row.boxes[1]->forceActivationState(ACTIVE_TAG);
  EXPECT_EQ(row.Manifolds(true).size(), 3u);  // with the floor and both neighbors
}

}  // namespace
}  // namespace pickbed::tests
