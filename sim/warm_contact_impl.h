#pragma once

// Private to sim's physics: contacts between convex pieces that start from what the last step knew.
//
// Bullet's own algorithm searches every pair of pieces anew in every step. Most pairs whose boxes
// overlap do not touch, and the plane that lay between them a step ago still does: testing it takes
// one vertex of each piece. Where it fails, it is still a good place to start from.
// (van den Bergen 1999, "A fast and robust GJK implementation", section 4.)

#include <btBulletDynamicsCommon.h>

#include <memory>

namespace pickbed {

// Bullet's defaults, but for pairs of hulls and boxes.
class WarmContactConfiguration : public btDefaultCollisionConfiguration {
 public:
  WarmContactConfiguration();
  ~WarmContactConfiguration() override;
  btCollisionAlgorithmCreateFunc* getCollisionAlgorithmCreateFunc(int type_a, int type_b) override;

 private:
  class Maker;
  std::unique_ptr<Maker> maker_;
};

}  // namespace pickbed
