#include "grasp/grippers/suction_cup.h"

#include <fmt/format.h>

#include <numbers>

#include "grasp/candidates.h"
#include "grasp/grippers/sizes.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr double kAirPressure_pa = 101325;

void Visit(GripperSpec& spec, SettingsVisitor& v) {
  CupSpec& cup = spec.cup;
  v.Real("radius_m", cup.radius_m, kGripperSize, "of the lip, m");
  v.Real("bellows_travel_m", cup.bellows_travel_m, kGripperSize,
         "from the uncompressed lip to the stem's end, m");
  v.Real("press_m", cup.press_m, {0, 1}, "compression that a grasp aims at, m");
  v.Real("bellows_npm", cup.bellows_npm, {1, 1e5}, "stiffness of the bellows until it seals, N/m");
  v.Real("lip_conform_m", cup.lip_conform_m, {0, 0.05},
         "unevenness along the rim that the lip still closes, m");
  v.Real("vacuum_n", cup.vacuum_n, {0.1, 5000}, "pull at which it comes off, N");
  v.Real("moment_limit_nm", cup.moment_limit_nm, {0.001, 500},
         "bending moment at which it comes off, Nm");
  v.Real("friction", cup.friction, {0.01, 3}, "of the lip; multiplies the part's own value");
  v.Real("break_after_s", cup.break_after_s, {0.001, 1},
         "limits are judged on the mean load over this time, s");
  v.Real("stem_radius_m", cup.stem_radius_m, kGripperSize, "of the stem, m");
  v.Real("stem_length_m", cup.stem_length_m, kGripperSize, "from the bellows to the palm, m");
  v.Vector3("palm_size_m", cup.palm_size_m, kGripperSize, "box behind the stem");
}

void Check(const GripperSpec& spec, const std::string& source) {
  const CupSpec& cup = spec.cup;
  CheckInput(cup.press_m < cup.bellows_travel_m,
             fmt::format("{}: press_m = {}: it must stay below the bellows_travel_m of {}", source,
                         cup.press_m, cup.bellows_travel_m));
  const double most_n = kAirPressure_pa * std::numbers::pi * cup.radius_m * cup.radius_m;
  CheckInput(cup.vacuum_n <= most_n,
             fmt::format("{}: vacuum_n = {}: the air presses a cup of radius_m = {} on with {:.3g} "
                         "N at most",
                         source, cup.vacuum_n, cup.radius_m, most_n));
  const double most_nm = cup.vacuum_n * cup.radius_m;
  CheckInput(cup.moment_limit_nm <= most_nm,
             fmt::format("{}: moment_limit_nm = {}: a lip tips over its rim at vacuum_n times "
                         "radius_m, which is {:.3g} Nm",
                         source, cup.moment_limit_nm, most_nm));
}

// The lip is always open.
std::optional<double> ApproachOpening(const GripperSpec&, double) { return 0; }

Hand& Add(PhysicsWorld& world, const GripperSpec& spec, double, const Pose& X_WG) {
  return world.AddCup(spec.cup, X_WG);
}

std::vector<AxisAlignedBox> Boxes(const GripperSpec& spec, double) { return CupBoxes(spec.cup); }

// Its lip seals on one part alone.
std::optional<AxisAlignedBox> Between(const GripperSpec&, double) { return std::nullopt; }

double MostOpen(const GripperSpec&) { return 0; }

double Travel(const GripperSpec&, double) { return 0; }

std::vector<AxisAlignedBox> SoftBoxes(const GripperSpec& spec) {
  const Eigen::Vector3d half(spec.cup.radius_m, spec.cup.radius_m, 0.5 * spec.cup.bellows_travel_m);
  return {{{0, 0, -half.z()}, half}};
}

// Hanging straight down.
double Capacity(const GripperSpec& spec, double) { return spec.cup.vacuum_n; }

std::string Summary(const GripperSpec& spec) {
  return fmt::format("lip of {:.0f} mm, {:g} N, {:g} Nm", 2e3 * spec.cup.radius_m,
                     spec.cup.vacuum_n, spec.cup.moment_limit_nm);
}

std::vector<GraspCandidate> Candidates(const ObjectModel& model, const GripperSpec& spec, Rng& rng,
                                       const GraspCandidateOptions& options) {
  return SuctionGrasps(model, spec, rng, options.suction, options.robust);
}

}  // namespace

MechanismRow SuctionCupRow() {
  return {.name = "suction_cup",
          .help = "a bellows whose lip seals on a part, until pull or moment break it off",
          .axes_G = {"x of the lip", "y of the lip", "the approach"},
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
          .needs = "place that closes its lip",
          .make_candidates = Candidates};
}

}  // namespace pickbed
