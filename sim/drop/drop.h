#pragma once

// Fills a bin with object instances and simulates them until they come to rest.

#include <functional>
#include <string>
#include <vector>

#include "scenes/base/random.h"
#include "scenes/base/settings.h"
#include "scenes/scene.h"
#include "sim/drop/certificate.h"
#include "sim/physics/physics_world.h"

namespace pickbed::sim {

// How instances are placed in the bin.
enum class Arrangement {
  kPile,    // poured in layers between walls that are removed when all is calm
  kPacked,  // placed on the floor one by one, upright and apart
  kHeap,    // poured into a shaft over the bin's center that is then removed
};

struct DropOptions {
  Arrangement arrangement = Arrangement::kPile;
  double shaft_share = 0.5;  // kHeap: shaft width over floor width; wider for long objects
  int place_attempts = 200;  // kPacked: positions tried before an instance counts as outside

  double layer_interval_s = 0.15;
  double max_s = 8;            // limit of the simulated time after the last layer
  double clearance_m = 0.003;  // between instances of a layer, to the walls and to the scene below
  double funnel_m = 10;        // height of the walls above the bin while it is filled
  double check_interval_s = 0.05;  // time between two checks for rest
  double fallen_m = 0.2;           // bodies deeper below the floor than this are removed
  int turn_attempts = 20;          // random orientations tried until one fits between the walls
  // Instances that overlap others or keep moving are taken out and poured again, at most this
  // often. A new drop of all instances takes several times as long, and may have such instances
  // again.
  int pour_again_rounds = 3;
  // A scene is calm if all instances sleep. It is also calm if for `calm_s` no instance's surface
  // has moved by more than `calm_diameters` times its diameter. An unstable pose moves much faster:
  // a 5 cm object tips over in 0.3 s.
  double calm_s = 0.4;
  double calm_diameters = 0.01;
  // A calm scene is woken and kept awake. It is at rest once no instance has moved by more than
  // `wake_diameters` times its diameter for `wake_s`. 0 s = being calm is sufficient.
  double wake_s = 1.0;
  double wake_diameters = 0.02;
  // Bullet has no friction against spinning on a point or rocking between two points. Damping stops
  // both. With 0.5 per second, one of twelve scenes of 50 instances still rocked after 8 s. With
  // 0.9, none did. Without contact reuse, 50 mixed instances take three times as long and creep for
  // seconds.
  PhysicsOptions physics{.angular_damping = 0.9, .contact_reuse_m = 0.0001};
  // Called often while the instances move; may be empty. An exception ends the drop.
  std::function<void()> on_wait = {};
  // Visits all options except `arrangement`, `physics` and `on_wait`.
  void Visit(SettingsVisitor& v);
};

struct DropResult {
  Scene scene;
  SceneCertificate certificate;
};

// Accepts "pile", "packed" or "heap". Throws InputError for other names.
Arrangement ArrangementFromName(const std::string& name);

// Drops `counts[i]` instances of objects[i] in random order and orientation. The result depends
// only on the arguments, including the state of `rng`. Each layer is packed into rows of disjoint
// cells above the scene, between walls that keep all instances over the bin until they rest.
// Poured instances that overlap others or do not rest are poured again before the walls go. Packed
// instances have a random yaw. Their up direction is the entry of ObjectModel::resting_O nearest to
// O's z, or z itself if there is none. Instances without a free place count as outside. Throws
// InputError if an object does not fit on the bin floor, and for options out of range. Throws
// std::logic_error if an object has no convex pieces, or if `counts` and `objects` differ in size.
DropResult DropInstances(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                         Rng& rng, const DropOptions& options = {});

}  // namespace pickbed::sim
