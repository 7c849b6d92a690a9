#pragma once

// Pours parts into a bin in layers and lets them come to rest.

#include <string>
#include <vector>

#include "scenes/random.h"
#include "scenes/scene.h"
#include "sim/physics_world.h"

namespace pickbed {

struct DropOptions {
  double layer_interval_s = 0.15;
  double max_s = 8;                // simulated, after the last layer; the loop is bounded by it
  double clearance_m = 0.003;      // between parts of a layer, to the walls and to the pile below
  double funnel_m = 10;            // height of the walls above the bin while it is filled
  double check_interval_s = 0.05;  // between two looks whether all are at rest
  double fallen_m = 0.2;           // parts further below the floor are taken out
  int turn_attempts = 20;          // random orientations tried until a part fits between the walls
  // A pile is at rest when all parts sleep, or when for this long no part's surface has moved by
  // more than this. (An unstable pose leaves it much faster: a 5 cm part tips over in 0.3 s.)
  double rest_s = 0.6;
  double rest_m = 0.0005;
  // Twice the world's iterations: what the solver leaves over keeps piles trembling, and a pile of
  // 48 parts of all kinds takes half as long to fall asleep. Damping stops parts that spin on a
  // point or swing between two, where Bullet has no friction: at 20 iterations one pile of 50 in
  // twelve still swung after 8 s with a loss of 0.5 a second, none with 0.9. Contacts are reused
  // until all are at rest for the first time without the funnel: over 20 piles of 50 that takes 0.7
  // of the time, and parts move less when the scene is rebuilt and woken (median 1.8 mm in a
  // second for the worst part of a pile, 3.9 mm without).
  PhysicsOptions physics{
      .solver_iterations = 40, .angular_damping = 0.9, .contact_reuse_m = 0.0001};
};

struct DropReport {
  bool at_rest = false;  // see DropOptions::rest_s; else timed out
  double simulated_s = 0;
  int left_bin = 0;  // parts whose centre of mass ended outside the bin: they are not in the scene
  double max_speed_mps = 0;  // at the end
  bool blew_up = false;
  double deepest_penetration_m = 0;  // hull against hull, margins not counted
};

struct DropResult {
  Scene scene;
  DropReport report;
};

// `counts[i]` parts of objects[i], in a random order and orientation, the same for the same state
// of `rng`. Each layer is packed into rows of non-overlapping cells above the pile, between walls
// that keep everything over the bin until the pile rests. Throws InputError when a part cannot lie
// on the bin's floor, std::logic_error when a part has no convex pieces.
DropResult DropParts(const Bin& bin, const ObjectSet& objects, const std::vector<int>& counts,
                     Rng& rng, const DropOptions& options = {});

}  // namespace pickbed
