#include "grasp/grippers/parallel_jaw.h"

#include <fmt/format.h>

#include "grasp/candidates/candidates.h"
#include "grasp/candidates/jaw_wrenches.h"
#include "scenes/base/error.h"
#include "scenes/objects/contact.h"

namespace pickbed::grasp {

void ParallelJaw::VisitOwn(SettingsVisitor& v) {
  v.Vector3("finger_size_m", hand.finger_size_m, kSize,
            "size of a finger: thickness x, width y, length z, m");
  v.Vector3("palm_size_m", hand.palm_size_m, kSize, "size of the box behind the fingers, m");
  v.Real("stroke_m", hand.stroke_m, kSize, "maximum opening between the pads, m");
  v.Real("finger_mass_kg", hand.finger_mass_kg, {0.001, 10}, "mass of each finger, kg");
  v.Real("force_n", hand.force_n, {0.1, 2000}, "force of each finger on the object, N");
  v.Real("close_speed_mps", hand.close_speed_mps, {0.001, 1}, "closing speed of each finger, m/s");
  v.Real("yield_n", hand.yield_n, {0.1, 2000},
         "push against the approach at which a finger yields, N");
  v.Real("pad_friction", hand.pad_friction, {0.01, 3},
         "friction factor of a pad; multiplies the object's friction");
}

void ParallelJaw::Validate(const std::string& source) const {
  CheckInput(2 * clearance_m < hand.stroke_m,
             fmt::format("{}: clearance_m = {}: twice this value must be below the stroke_m of {}",
                         source, clearance_m, hand.stroke_m));
  CheckInput(hand.palm_size_m.x() >= hand.stroke_m,
             fmt::format("{}: palm_size_m = [{}, {}, {}]: its x must be at least the stroke_m of "
                         "{}, since the open fingers hang from it",
                         source, hand.palm_size_m.x(), hand.palm_size_m.y(), hand.palm_size_m.z(),
                         hand.stroke_m));
}

std::array<const char*, 3> ParallelJaw::axes_G() const {
  return {"the closing direction", "the fingers' width", "the approach"};
}

std::string ParallelJaw::Summary() const {
  return fmt::format("opens {:.0f} mm, {:g} N", 1e3 * hand.stroke_m, hand.force_n);
}

std::optional<double> ParallelJaw::ApproachOpening_m(double width_m) const {
  return JawOpening_m(hand, clearance_m, width_m);
}

double ParallelJaw::TravelTime_s(double opening_m) const {
  return 0.5 * opening_m / hand.close_speed_mps;
}

std::shared_ptr<const Gripper> ParallelJaw::WithForce(double factor) const {
  auto gripper = std::make_shared<ParallelJaw>(*this);
  gripper->hand.force_n *= factor;
  return gripper;
}

// The end stop of the fingers is at the opening where they start.
Hand& ParallelJaw::AddTo(PhysicsWorld& world, double opening_m, const Pose& X_WG) const {
  HandSpec limited = hand;
  limited.stroke_m = opening_m;
  return AddJawHand(world, limited, X_WG);
}

std::vector<AxisAlignedBox> ParallelJaw::Boxes(double opening_m) const {
  return HandBoxes(hand, opening_m);
}

std::optional<AxisAlignedBox> ParallelJaw::RegionBetween(double opening_m) const {
  const Eigen::Vector3d half_pad = 0.5 * hand.finger_size_m;
  return AxisAlignedBox{{0, 0, -half_pad.z()}, {0.5 * opening_m, half_pad.y(), half_pad.z()}};
}

// Moved by a quarter of their width, the pads keep most of the contact.
double ParallelJaw::MaxAside_m() const { return 0.25 * hand.finger_size_m.y(); }

double ParallelJaw::Capacity_n(double object_friction) const {
  return 2 * hand.force_n * PairFriction(object_friction, hand.pad_friction);
}

std::vector<GraspCandidate> ParallelJaw::MakeCandidates(
    const ObjectModel& model, Rng& rng, const GraspCandidateOptions& options) const {
  const AntipodalOptions& pairs = options.antipodal;
  auto candidates = AntipodalGrasps(model, hand, clearance_m, rng, pairs);
  if (candidates.empty()) return candidates;
  const SurfacePoints surface =
      SpreadPoints(model.mesh_O, pairs.point_spacing_m, pairs.min_points, pairs.max_points, rng);
  JudgeJawGrasps(model, hand, clearance_m, surface, options.robust, rng.Next(), candidates);
  return candidates;
}

}  // namespace pickbed::grasp
