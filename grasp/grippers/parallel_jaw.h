#pragma once

// Parallel jaw: two coupled fingers that close along x of G with a force limit. The frame and the
// dimensions are drawn in sim/hands/jaw_hand.h.

#include "grasp/gripper.h"
#include "sim/hands/jaw_hand.h"

namespace pickbed::grasp {

// Parallel jaw; its candidates are antipodal (grasp/candidates/antipodal.h).
class ParallelJaw : public Gripper {
 public:
  static constexpr const char* kMechanism = "parallel_jaw";

  HandSpec hand;

  const char* mechanism() const override { return kMechanism; }
  std::array<const char*, 3> axes_G() const override;
  const char* needs() const override { return "antipodal pair that fits its stroke"; }
  std::string Summary() const override;
  // The palm must carry the open fingers, and the clearance must leave some of the stroke.
  void Validate(const std::string& source) const override;
  // Width of the object plus the clearance on each side; nullopt beyond the stroke.
  std::optional<double> ApproachOpening_m(double width_m) const override;
  double MaxOpening_m() const override { return hand.stroke_m; }
  double TravelTime_s(double opening_m) const override;
  std::shared_ptr<const Gripper> WithForce(double factor) const override;
  Hand& AddTo(PhysicsWorld& world, double opening_m, const Pose& X_WG) const override;
  std::vector<AxisAlignedBox> Boxes(double opening_m) const override;
  std::optional<AxisAlignedBox> RegionBetween(double opening_m) const override;
  double MaxAside_m() const override;
  bool PullsAside() const override { return true; }
  // Friction of both pads.
  double Capacity_n(double object_friction) const override;
  std::vector<GraspCandidate> MakeCandidates(const ObjectModel& model, Rng& rng,
                                             const GraspCandidateOptions& options) const override;

 protected:
  void VisitOwn(SettingsVisitor& v) override;
};

}  // namespace pickbed::grasp
