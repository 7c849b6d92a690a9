#pragma once

// Whether a scene stays as it is, and what the makers of scenes need to tell.

#include "scenes/scene.h"
#include "sim/drop.h"

namespace pickbed {

// Small parts need shorter steps, since gravity and contacts that are kept move all parts by the
// same lengths: time goes with the root of the size, as in free fall.
PhysicsOptions PhysicsFor(const ObjectSet& objects, PhysicsOptions physics);

// The furthest that any part's surface has moved, also as a share of that part's diameter.
struct Movement {
  double m = 0;
  double diameters = 0;

  // Of a part, by a bound for any point of its bounding box.
  void Include(const Eigen::AlignedBox3d& box_O, double diameter_m, const Pose& before_X_WO,
               const Pose& after_X_WO);
};

// The certificate of a scene as it stands: a world is built from its poses, with all parts awake
// and kept awake for `options.wake_s`, and no part may move by more than `options.wake_diameters`
// meanwhile. The poses that are certified are those at the beginning, which `scene` keeps. Without
// samples of energy. Throws std::logic_error when a part has no convex pieces.
SceneCertificate CertifyRest(const Scene& scene, const ObjectSet& objects,
                             const DropOptions& options = {});

}  // namespace pickbed
