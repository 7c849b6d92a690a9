#pragma once

// Suction cup: one bellows with a lip that seals on an object. The frame and the dimensions are
// drawn in sim/hands/suction_hand.h. The cup touches an object from one side, so the width of the
// object does not matter.

#include "grasp/gripper.h"
#include "sim/hands/suction_hand.h"

namespace pickbed::grasp {

// Suction cup; its candidates are points where the lip seals (grasp/candidates/suction.h).
class SuctionCup : public Gripper {
 public:
  static constexpr const char* kMechanism = "suction_cup";

  CupSpec cup;

  const char* mechanism() const override { return kMechanism; }
  std::array<const char*, 3> axes_G() const override;
  const char* needs() const override { return "surface that seals its lip"; }
  std::string Summary() const override;
  // The bellows must be longer than the press, and the air pressure limits force and moment.
  void Validate(const std::string& source) const override;
  // The lip is always open.
  std::optional<double> ApproachOpening_m(double) const override { return 0; }
  double MaxOpening_m() const override { return 0; }
  double TravelTime_s(double) const override { return 0; }
  std::shared_ptr<const Gripper> WithForce(double factor) const override;
  Hand& AddTo(PhysicsWorld& world, double opening_m, const Pose& X_WG) const override;
  std::vector<AxisAlignedBox> Boxes(double opening_m) const override;
  std::vector<AxisAlignedBox> SoftBoxes() const override;
  // By the strength of the lip (sim/hands/suction_hand.h): pull, bending, shear and torsion.
  double WeightShare(const ObjectModel& object, const Pose& X_GO,
                     const Eigen::Vector3d& down_G) const override;
  // The pull at which the lip detaches, for an object that hangs straight down.
  double Capacity_n(double) const override { return cup.vacuum_n; }
  std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, Rng& rng,
                                             const GraspCandidateOptions& options) const override;

 protected:
  void VisitOwn(SettingsVisitor& v) override;
};

}  // namespace pickbed::grasp
