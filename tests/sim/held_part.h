#pragma once

// A part alone, taken from a table by a parallel jaw, for tests of the mechanics of holding.

#include <cmath>
#include <memory>

#include "scenes/gravity.h"
#include "sim/hand_joints.h"
#include "sim/physics_world.h"
#include "tests/sim/hand_paths.h"
#include "tests/sim/physics_parts.h"

namespace pickbed {

struct HeldPart {
  std::shared_ptr<const ObjectModel> model;
  PhysicsWorld world;
  Hand* hand = nullptr;
  Pose X_WG;

  // The table's top is z = 0, a bar 3 cm wide between the fingers; the part stands on it at X_WO,
  // the open hand around it at X_WG.
  HeldPart(std::shared_ptr<const ObjectModel> part, const Pose& X_WO, const HandSpec& spec,
           const Pose& hand_pose, const PhysicsOptions& options = {})
      : model(std::move(part)), world(options), X_WG(hand_pose) {
    world.AddStaticBox(Translation({0, 0, -0.05}), {0.015, 0.5, 0.05}, 0.5);
    world.AddPart(*model, X_WO);
    hand = &world.AddHand(spec, X_WG);
    Stay(world, *hand, X_WG, 0.1);
    hand->Close();
    Stay(world, *hand, X_WG, 0.5);
  }

  Pose X_GO() const { return hand->X_WG().inverse() * world.X_WO(0); }
  // Of the centre of mass in the hand, since `before`.
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

// Pointing down, then turned about the closing axis.
inline Pose TurnedHand(double turn_rad, const Eigen::Vector3d& p_W) {
  const Pose over = HandOver(p_W);
  return MakePose(Eigen::Matrix3d(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitX()).matrix() *
                                  over.linear()),
                  p_W);
}

}  // namespace pickbed
