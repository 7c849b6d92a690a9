#pragma once

// Private to sim/physics: contact search between convex pieces that starts from the last step's
// result.
//
// Bullet's own algorithm searches every pair of pieces from scratch in every step. Most pairs with
// overlapping bounding boxes do not touch, and the separating plane of the last step is still
// valid. Its test needs one vertex of each piece. If it fails, its axis is still a good start for
// the search (van den Bergen 1999, "A fast and robust GJK implementation", section 4).

#include <btBulletDynamicsCommon.h>

#include <memory>

#include "sim/layer.h"

namespace pickbed::sim {

// Uses Bullet's default algorithms, except for pairs of convex hulls and boxes.
class WarmContactConfiguration : public btDefaultCollisionConfiguration {
 public:
  WarmContactConfiguration();
  ~WarmContactConfiguration() override;
  btCollisionAlgorithmCreateFunc* getCollisionAlgorithmCreateFunc(int type_a, int type_b) override;

 private:
  class Maker;
  std::unique_ptr<Maker> maker_;
};

}  // namespace pickbed::sim
