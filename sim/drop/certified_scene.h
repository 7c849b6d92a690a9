#pragma once

// Creates settled scenes that pass the scene certificate, and certifies existing scenes.

#include <optional>
#include <string>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/scene.h"
#include "sim/drop/certificate.h"
#include "sim/drop/drop.h"

namespace pickbed::sim {

// Returns the physics options for the smallest object's size. Objects smaller than 4 cm need
// shorter steps, because gravity and kept contacts move all objects by the same lengths. Time
// scales with the square root of the size, as in free fall.
PhysicsOptions PhysicsFor(const ObjectSet& objects, PhysicsOptions physics);

// The largest movement of any instance's surface, in metres and as a share of its diameter.
struct Movement {
  double m = 0;
  double diameters = 0;

  // Includes one instance, by an upper bound for all points of its bounding box.
  void Include(const Eigen::AlignedBox3d& box_O, double diameter_m, const Pose& before_X_WO,
               const Pose& after_X_WO);
};

// Certifies a scene as it is. It builds a world from the scene's poses and keeps all instances
// awake for `options.wake_s`. No instance may move by more than `options.wake_diameters` in that
// time. The certified poses are the initial ones, in `scene`. The certificate has no energy
// samples. Throws std::logic_error if an object has no convex pieces.
SceneCertificate CertifyRest(const Scene& scene, const ObjectSet& objects,
                             const DropOptions& options = {});

// Input of MakeScene() and TryScene().

struct SceneRequest {
  Bin bin;
  const ObjectSet& objects;  // must have convex pieces
  std::vector<int> counts;   // number of instances of each object
  uint64_t seed = 0;         // seed of the scenario
  BinIndex bin_index{0};
  // Name of the random streams. Another name gives another scene of the same bin.
  std::string stage = "drop";
};

struct RefusedScene {
  int attempt = 0;
  std::vector<std::string> faults;
};

struct CertifiedScene {
  Scene scene;
  SceneCertificate certificate;
  std::vector<RefusedScene> refused;  // refused earlier attempts, in order
};

// Drops scenes until one has no fault. Each attempt has its own random stream, derived from seed,
// bin index, stage and attempt. Throws InputError with the last scene's faults after `max_attempts`
// refused scenes, and where DropInstances() throws.
CertifiedScene MakeScene(const SceneRequest& request, const DropOptions& options = {},
                         int max_attempts = 10);

// Result of TryScene(), for callers that accept trials without a certified scene.

struct SceneSamples {
  std::optional<CertifiedScene> made;  // includes the refused scenes
  std::vector<RefusedScene> refused;   // in order
};

// Same as MakeScene(), but returns without a scene after `max_attempts` refused scenes. Throws
// where DropInstances() throws.
SceneSamples TryScene(const SceneRequest& request, const DropOptions& options,
                      int max_attempts = 10);

}  // namespace pickbed::sim
