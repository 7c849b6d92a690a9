#pragma once

// Pours parts into a bin in layers and lets them come to rest.

#include <string>
#include <vector>

#include "scenes/random.h"
#include "scenes/scene.h"
#include "sim/physics_world.h"
#include "sim/scene_certificate.h"

namespace pickbed {

enum class Arrangement {
  kPile,    // poured in layers between walls that stand until all is calm
  kPacked,  // stood on the floor one by one, upright and apart
  kHeap,    // poured into a shaft over the middle that is then taken away
};

struct DropOptions {
  Arrangement arrangement = Arrangement::kPile;
  double shaft_share = 0.5;  // kHeap: of the floor's length and width, or more for long parts
  int place_attempts = 200;  // kPacked: places tried for a part before it counts as outside

  double layer_interval_s = 0.15;
  double max_s = 8;                // simulated, after the last layer; the loop is bounded by it
  double clearance_m = 0.003;      // between parts of a layer, to the walls and to the pile below
  double funnel_m = 10;            // height of the walls above the bin while it is filled
  double check_interval_s = 0.05;  // between two looks whether all are at rest
  double fallen_m = 0.2;           // parts further below the floor are taken out
  int turn_attempts = 20;          // random orientations tried until a part fits between the walls
  // A pile is calm when all parts sleep, or when for this long no part's surface has moved by more
  // than this share of its diameter. (An unstable pose leaves it much faster: a 5 cm part tips over
  // in 0.3 s.)
  double calm_s = 0.4;
  double calm_diameters = 0.01;
  // A calm pile is woken and stays awake until for this long no part has moved by more than this
  // share of its diameter: that is the certificate's rest. 0 s = a calm pile will do.
  double wake_s = 1.0;
  double wake_diameters = 0.02;
  // Damping stops parts that spin on a point or swing between two, where Bullet has no friction:
  // one pile of 50 in twelve still swung after 8 s with a loss of 0.5 a second, none with 0.9.
  // Without contact reuse 50 mixed parts take three times as long and creep for seconds.
  PhysicsOptions physics{.angular_damping = 0.9, .contact_reuse_m = 0.0001};
};

struct DropResult {
  Scene scene;
  SceneCertificate certificate;
};

// "pile", "packed" or "heap", else InputError.
Arrangement ArrangementFromName(const std::string& name);

// `counts[i]` parts of objects[i], in a random order and orientation, the same for the same state
// of `rng`. Each layer is packed into rows of non-overlapping cells above the pile, between walls
// that keep everything over the bin until the pile rests. Packed parts stand with that of their
// resting directions (ObjectModel::resting_O) up that is nearest to O's z, or with z itself where
// none is known, turned about the vertical at random; those that find no free place count as
// outside. Throws InputError when a part cannot lie on the bin's floor, std::logic_error when a
// part has no convex pieces.
DropResult DropParts(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                     Rng& rng, const DropOptions& options = {});

}  // namespace pickbed
