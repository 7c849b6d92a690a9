#include "grasp/grippers/parallel_jaw.h"

#include <fmt/format.h>

#include "grasp/candidates.h"
#include "grasp/grippers/sizes.h"
#include "grasp/jaw_hold.h"
#include "scenes/check.h"
#include "scenes/friction.h"

namespace pickbed {
namespace {

void Visit(GripperSpec& spec, SettingsVisitor& v) {
  HandSpec& hand = spec.hand;
  v.Vector3("finger_size_m", hand.finger_size_m, kGripperSize,
            "x thickness, y width, z length of a finger");
  v.Vector3("palm_size_m", hand.palm_size_m, kGripperSize, "box behind the fingers");
  v.Real("stroke_m", hand.stroke_m, kGripperSize, "largest opening between the pads, m");
  v.Real("finger_mass_kg", hand.finger_mass_kg, {0.001, 10}, "of each finger, kg");
  v.Real("force_n", hand.force_n, {0.1, 2000}, "of each finger on the part, N");
  v.Real("close_speed_mps", hand.close_speed_mps, {0.001, 1}, "of each finger, m/s");
  v.Real("pad_friction", hand.pad_friction, {0.01, 3}, "of a pad; multiplies the part's own value");
}

// Pads that cannot reach past the palm, or a clearance that eats the stroke.
void Check(const GripperSpec& spec, const std::string& source) {
  const HandSpec& hand = spec.hand;
  CheckInput(2 * spec.clearance_m < hand.stroke_m,
             fmt::format("{}: clearance_m = {}: twice that must stay below the stroke_m of {}",
                         source, spec.clearance_m, hand.stroke_m));
  CheckInput(hand.palm_size_m.x() >= hand.stroke_m,
             fmt::format("{}: palm_size_m = [{}, {}, {}]: its x must be at least the stroke_m of "
                         "{}, since the open fingers hang from it",
                         source, hand.palm_size_m.x(), hand.palm_size_m.y(), hand.palm_size_m.z(),
                         hand.stroke_m));
}

// The part's width and the clearance on each side; nullopt beyond the stroke.
std::optional<double> ApproachOpening(const GripperSpec& spec, double width_m) {
  const double opening = width_m + 2 * spec.clearance_m;
  if (opening > spec.hand.stroke_m) return std::nullopt;
  return opening;
}

// Its sliders' end stop is where it starts.
Hand& Add(PhysicsWorld& world, const GripperSpec& spec, double opening_m, const Pose& X_WG) {
  HandSpec hand = spec.hand;
  hand.stroke_m = opening_m;
  return world.AddHand(hand, X_WG);
}

std::vector<AxisAlignedBox> Boxes(const GripperSpec& spec, double opening_m) {
  return HandBoxes(spec.hand, opening_m);
}

std::optional<AxisAlignedBox> Between(const GripperSpec& spec, double opening_m) {
  const Eigen::Vector3d half_pad = 0.5 * spec.hand.finger_size_m;
  return AxisAlignedBox{{0, 0, -half_pad.z()}, {0.5 * opening_m, half_pad.y(), half_pad.z()}};
}

double MostOpen(const GripperSpec& spec) { return spec.hand.stroke_m; }

double Travel(const GripperSpec& spec, double opening_m) {
  return 0.5 * opening_m / spec.hand.close_speed_mps;
}

std::vector<AxisAlignedBox> SoftBoxes(const GripperSpec&) { return {}; }

// Friction of two pads.
double Capacity(const GripperSpec& spec, double part_friction) {
  return 2 * spec.hand.force_n * PairFriction(part_friction, spec.hand.pad_friction);
}

std::string Summary(const GripperSpec& spec) {
  return fmt::format("opens {:.0f} mm, {:g} N", 1e3 * spec.hand.stroke_m, spec.hand.force_n);
}

std::vector<GraspCandidate> Candidates(const ObjectModel& model, const GripperSpec& spec, Rng& rng,
                                       const GraspCandidateOptions& options) {
  const AntipodalOptions& pairs = options.antipodal;
  auto candidates = AntipodalGrasps(model, spec, rng, pairs);
  if (candidates.empty()) return candidates;
  const SurfacePoints surface =
      SpreadPoints(model.mesh_O, pairs.point_spacing_m, pairs.min_points, pairs.max_points, rng);
  JudgeJawGrasps(model, spec, surface, options.robust, rng.Next(), candidates);
  return candidates;
}

}  // namespace

MechanismRow ParallelJawRow() {
  return {.name = "parallel_jaw",
          .help = "two coupled fingers on a slider with a force limit",
          .axes_G = {"the closing direction", "the fingers' width", "the approach"},
          .visit = Visit,
          .check = Check,
          .approach_opening_m = ApproachOpening,
          .most_open_m = MostOpen,
          .travel_s = Travel,
          .add = Add,
          .boxes = Boxes,
          .between = Between,
          .soft_boxes = SoftBoxes,
          .capacity_n = Capacity,
          .summary = Summary,
          .needs = "antipodal pair that fits its stroke",
          .make_candidates = Candidates};
}

}  // namespace pickbed
