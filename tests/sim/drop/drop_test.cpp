#include "sim/drop/drop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/base/error.h"
#include "sim/drop/penetration.h"
#include "tests/sim/physics_objects.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

DropResult DropMixed(uint64_t seed, int each) {
  Rng rng(seed);
  return DropInstances(Bin{}, MixedObjects(), {each, each, each, each}, rng);
}

bool SameBits(const Scene& a, const Scene& b) {
  if (a.objects.size() != b.objects.size()) return false;
  for (size_t i = 0; i < a.objects.size(); ++i) {
    if (a.objects[i].object != b.objects[i].object) return false;
    if (a.objects[i].X_WO.matrix() != b.objects[i].X_WO.matrix()) return false;
  }
  return true;
}

TEST(DropInstances, MixedInstancesComeToRestInsideWithoutOverlap) {
  for (const uint64_t seed : {0, 1, 2}) {
    const DropResult drop = DropMixed(seed, 5);
    EXPECT_TRUE(drop.certificate.at_rest) << "seed " << seed;
    EXPECT_FALSE(drop.certificate.blew_up) << "seed " << seed;
    EXPECT_EQ(drop.certificate.instances_outside, 0) << "seed " << seed;
    EXPECT_EQ(drop.scene.objects.size(), 20u) << "seed " << seed;
    EXPECT_LT(drop.certificate.deepest_penetration_m, 0.0005) << "seed " << seed;
    EXPECT_LT(drop.certificate.max_speed_mps, 0.01) << "seed " << seed;
  }
}

TEST(DropInstances, SettledSceneStaysAtRestWhenAwake) {
  const ObjectSet objects = MixedObjects();
  for (const uint64_t seed : {0, 1, 2}) {
    const DropResult drop = DropMixed(seed, 5);
    PhysicsWorld world;
    world.AddBin(drop.scene.bin);
    for (const PosedObject& object : drop.scene.objects) {
      world.AddInstance(*objects[object.object], object.X_WO);
    }
    world.ForbidSleep();
    while (world.time_s() < 1) world.Step();
    for (size_t i = 0; i < drop.scene.objects.size(); ++i) {
      const Eigen::Vector3d before = drop.scene.objects[i].X_WO.translation();
      EXPECT_LT((world.X_WO(static_cast<int>(i)).translation() - before).norm(), 0.001)
          << "seed " << seed << " instance " << i;
    }
  }
}

// The time limit is so short that several scenes do not become calm in it. Then their moving
// instances are poured again.
TEST(DropInstances, PouringAgainKeepsTheCountsAndSavesScenes) {
  DropOptions once;
  once.max_s = 1.6;  // at most half of it until the scene is calm
  once.wake_s = 0;
  once.pour_again_rounds = 0;
  DropOptions again = once;
  again.pour_again_rounds = 4;
  int certified_once = 0, certified_again = 0;
  for (const uint64_t seed : {0, 1, 2, 3, 4, 5, 6, 7}) {
    const auto drop = [&](const DropOptions& options) {
      Rng rng(seed);
      return DropInstances(Bin{}, MixedObjects(), {4, 4, 4, 4}, rng, options);
    };
    certified_once += Faults(drop(once).certificate).empty();
    const DropResult result = drop(again);
    certified_again += Faults(result.certificate).empty();
    std::vector<int> counts(4);
    for (const PosedObject& posed : result.scene.objects) ++counts[posed.object];
    EXPECT_EQ(counts, (std::vector<int>{4, 4, 4, 4})) << "seed " << seed;
    EXPECT_EQ(result.certificate.instances_outside, 0) << "seed " << seed;
  }
  EXPECT_GT(certified_again, certified_once);
}

// Balls without friction and damping roll for a long time. One of ten instances is poured again
// after two seconds, one of nine after four. Then both have four more.
TEST(DropInstances, FewThatKeepMovingArePouredAgainSooner) {
  const auto cube = BoxObject({0.03, 0.03, 0.03}, 0.1);
  auto ball = std::make_shared<ObjectModel>(*BoxObject({0.03, 0.03, 0.03}, 0.1, 0));
  ball->mesh_O = SphereMesh(0.015, 3);
  ball->convex_pieces_O = {{ball->mesh_O.vertices}};
  DropOptions options;
  options.physics.angular_damping = 0;
  options.max_s = 8;
  options.pour_again_rounds = 1;
  options.wake_s = 0;
  const auto longest_s = [&](int cubes) {
    double longest_s = 0;
    for (uint64_t seed = 0; seed < 10; ++seed) {
      Rng rng(seed);
      const DropResult drop = DropInstances(Bin{}, {cube, ball}, {cubes, 1}, rng, options);
      longest_s = std::max(longest_s, drop.certificate.simulated_s);
    }
    return longest_s;
  };
  const double one_of_ten_s = longest_s(9), one_of_nine_s = longest_s(8);
  EXPECT_GT(one_of_ten_s, 6);
  EXPECT_LT(one_of_ten_s, 7);
  EXPECT_GT(one_of_nine_s, 8);
}

TEST(DropInstances, ExceptionOfTheWaitFunctionEndsTheDrop) {
  DropOptions options;
  int calls = 0;
  options.on_wait = [&] {
    if (++calls == 3) throw std::runtime_error("stop");
  };
  Rng rng(0);
  EXPECT_THROW(DropInstances(Bin{}, MixedObjects(), {1, 1, 1, 1}, rng, options),
               std::runtime_error);
  EXPECT_EQ(calls, 3);
}

TEST(DropInstances, SameSeedGivesSameBitsBesideAnotherWorld) {
  const DropResult first = DropMixed(7, 4);
  EXPECT_TRUE(SameBits(first.scene, DropMixed(7, 4).scene));

  PhysicsWorld other;
  const auto cube = BoxObject({0.04, 0.04, 0.04}, 0.1);
  other.AddBin(Bin{});
  other.AddInstance(*cube, Translation({0, 0, 0.5}));
  other.Step();
  EXPECT_TRUE(SameBits(first.scene, DropMixed(7, 4).scene));

  EXPECT_FALSE(SameBits(first.scene, DropMixed(8, 4).scene));
}

TEST(DropInstances, InstancesAreNumberedAndObjectCountsKept) {
  Rng rng(3);
  const DropResult drop = DropInstances(Bin{}, MixedObjects(), {3, 0, 2, 4}, rng);
  std::vector<int> of_object(4, 0);
  for (size_t i = 0; i < drop.scene.objects.size(); ++i) {
    EXPECT_EQ(drop.scene.objects[i].instance, static_cast<int>(i));
    ++of_object[drop.scene.objects[i].object];
  }
  EXPECT_EQ(of_object, (std::vector<int>{3, 0, 2, 4}));
}

TEST(DropInstances, InstancesOutsideAreCountedAndNotInTheScene) {
  Bin tray;
  tray.inner_size_m = {0.16, 0.12, 0.03};
  Rng rng(1);
  const DropResult drop = DropInstances(tray, {BoxObject({0.05, 0.05, 0.05}, 0.1)}, {30}, rng);
  EXPECT_GT(drop.certificate.instances_outside, 0);
  EXPECT_EQ(drop.certificate.instances_outside + static_cast<int>(drop.scene.objects.size()), 30);
  EXPECT_FALSE(drop.certificate.blew_up);
  for (const PosedObject& object : drop.scene.objects) {
    EXPECT_LT(std::abs(object.X_WO.translation().x()), 0.08);
    EXPECT_LT(std::abs(object.X_WO.translation().y()), 0.06);
    EXPECT_GT(object.X_WO.translation().z(), 0);
  }
}

TEST(DropInstances, RodAsLongAsTheBinComesToRest) {
  for (const uint64_t seed : {0, 1, 2}) {
    Rng rng(seed);
    const DropResult drop = DropInstances(Bin{}, {BoxObject({0.02, 0.39, 0.02}, 0.3)}, {4}, rng);
    EXPECT_EQ(drop.certificate.instances_outside, 0);
    EXPECT_TRUE(drop.certificate.at_rest);
  }
}

TEST(DropInstances, EmptyBinStaysEmpty) {
  Rng rng(0);
  const DropResult drop = DropInstances(Bin{}, MixedObjects(), {0, 0, 0, 0}, rng);
  EXPECT_TRUE(drop.certificate.at_rest);
  EXPECT_TRUE(drop.scene.objects.empty());
}

TEST(DropInstances, RefusesAnObjectLargerThanTheBin) {
  Rng rng(0);
  const ObjectSet objects{BoxObject({0.1, 0.1, 0.1}, 1),
                          ObjectOfBoxes("girder", {{{0, 0, 0}, {0.02, 0.25, 0.01}}}, 1)};
  EXPECT_NO_THROW(DropInstances(Bin{}, objects, {1, 0}, rng));
  try {
    DropInstances(Bin{}, objects, {1, 1}, rng);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "object 'girder' is 0.500 x 0.040 x 0.020 m and does not fit into the bin's 0.400 x "
        "0.300 m floor: use a larger bin or check the mesh's unit");
  }
}

TEST(DropInstances, ObjectWithoutPiecesIsALogicError) {
  Rng rng(0);
  auto bare = std::make_shared<ObjectModel>(*BracketObject());
  bare->convex_pieces_O.clear();
  EXPECT_THROW(DropInstances(Bin{}, {bare}, {1}, rng), std::logic_error);
}

TEST(Arrangements, PackedInstancesAreUprightAndSeparate) {
  ObjectSet objects = MixedObjects();
  for (auto& object : objects) {
    auto copy = std::make_shared<ObjectModel>(*object);
    copy->resting_O = {{Eigen::Vector3d::UnitX(), 0.7}, {Eigen::Vector3d::UnitZ(), 0.3}};
    object = copy;
  }
  DropOptions options;
  options.arrangement = Arrangement::kPacked;
  Rng rng(1);
  const DropResult drop = DropInstances(Bin{}, objects, {2, 2, 2, 2}, rng, options);
  EXPECT_TRUE(Faults(drop.certificate).empty());
  ASSERT_EQ(drop.scene.objects.size(), 8u);
  for (const PosedObject& a : drop.scene.objects) {
    EXPECT_GT(a.X_WO.linear()(2, 2), 0.99) << "not upright";
    for (const PosedObject& b : drop.scene.objects) {
      if (a.instance >= b.instance) continue;
      Scene grown;  // moved together by less than the clearance, they do not touch
      const Eigen::Vector3d towards = b.X_WO.translation() - a.X_WO.translation();
      const Pose nearer = Translation(0.002 * towards.normalized()) * a.X_WO;
      grown.bin.inner_size_m = {2, 2, 0};
      grown.objects = {{InstanceId{0}, a.object, Translation({0, 0, 0.01}) * nearer},
                       {InstanceId{1}, b.object, Translation({0, 0, 0.01}) * b.X_WO}};
      EXPECT_EQ(DeepestPenetration(grown, objects), 0);
    }
  }
}

TEST(Arrangements, PackedInstancesWithoutRoomAreCounted) {
  DropOptions options;
  options.arrangement = Arrangement::kPacked;
  Bin tray;
  tray.inner_size_m = {0.12, 0.12, 0.1};
  Rng rng(1);
  const DropResult drop =
      DropInstances(tray, {BoxObject({0.05, 0.05, 0.05}, 0.1)}, {9}, rng, options);
  EXPECT_GE(drop.certificate.instances_outside, 5);
  EXPECT_EQ(drop.certificate.instances_outside + drop.scene.objects.size(), 9u);
}

// Without walls the instances stay near the center and form a heap higher than one cube.
TEST(Arrangements, HeapOnATableStaysTogether) {
  DropOptions options;
  options.arrangement = Arrangement::kHeap;
  Bin table;
  table.inner_size_m = {0.6, 0.6, 0};
  const ObjectSet cubes{BoxObject({0.04, 0.04, 0.04}, 0.1)};
  Rng rng(2);
  const DropResult drop = DropInstances(table, cubes, {40}, rng, options);
  EXPECT_TRUE(Faults(drop.certificate).empty());
  double highest_m = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  for (const PosedObject& object : drop.scene.objects) {
    highest_m = std::max(highest_m, object.X_WO.translation().z());
    center += object.X_WO.translation() / 40;
  }
  EXPECT_GT(highest_m, 0.05);
  EXPECT_LT(center.head<2>().norm(), 0.05);
}

TEST(Arrangements, AreFoundByName) {
  EXPECT_EQ(ArrangementFromName("heap"), Arrangement::kHeap);
  EXPECT_THROW(ArrangementFromName("tower"), InputError);
}

}  // namespace
}  // namespace pickbed::tests
