#pragma once

// One instance, picked from a table by a parallel jaw, for tests of the mechanics of holding.

#include <cmath>
#include <memory>

#include "scenes/objects/contact.h"
#include "sim/hands/jaw_hand.h"
#include "sim/physics/physics_world.h"
#include "tests/sim/hand_paths.h"
#include "tests/sim/physics_objects.h"

namespace pickbed::tests {

struct HeldObject {
  std::shared_ptr<const ObjectModel> model;
  PhysicsWorld world;
  Hand* hand = nullptr;
  Pose X_WG;

  // Closes the hand at `hand_pose` on the instance at X_WO. The table is a bar, 3 cm wide along x,
  // between the fingers; its top is z = 0.
  HeldObject(std::shared_ptr<const ObjectModel> object, const Pose& X_WO, const HandSpec& spec,
             const Pose& hand_pose, const PhysicsOptions& options = {})
      : model(std::move(object)), world(options), X_WG(hand_pose) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.015, 0.5, 0.05}, 0.5);
    world.AddInstance(*model, X_WO);
    hand = &AddJawHand(world, spec, X_WG);
    Stay(world, *hand, X_WG, 0.1);
    hand->Close();
    Stay(world, *hand, X_WG, 0.5);
  }

  Pose X_GO() const { return hand->X_WG().inverse() * world.X_WO(0); }
  // Returns the displacement of the center of mass relative to the hand since `X_GO_before`, in
  // metres.
  double Slip_m(const Pose& X_GO_before) const {
    const Eigen::Vector3d& com_O = model->mass.com_O;
    return (X_GO() * com_O - X_GO_before * com_O).norm();
  }
  double Turn_rad(const Pose& X_GO_before) const {
    return RotationAngleRad(X_GO_before.linear(), X_GO().linear());
  }
  void Lift(double height_m, double duration_s) {
    X_WG.translation().z() += height_m;
    MoveAlongMinimumJerk(world, *hand, X_WG, duration_s);
  }
  void Rest(double duration_s) { Stay(world, *hand, X_WG, duration_s); }
};

// Returns a hand pose that points down, then is rotated about the closing axis.
inline Pose RotatedHand(double turn_rad, const Eigen::Vector3d& p_W) {
  const Pose over = HandOver(p_W);
  return MakePose(Eigen::Matrix3d(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitX()).matrix() *
                                  over.linear()),
                  p_W);
}

}  // namespace pickbed::tests
