#include "grasp/grippers/suction_cup.h"

#include <fmt/format.h>

#include <numbers>

#include "grasp/candidates/candidates.h"
#include "scenes/base/error.h"
#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

constexpr double kAirPressure_pa = 101325;

}  // namespace

void SuctionCup::VisitOwn(SettingsVisitor& v) {
  v.Real("radius_m", cup.radius_m, kSize, "radius of the lip, m");
  v.Real("bellows_travel_m", cup.bellows_travel_m, kSize,
         "travel of the bellows from the uncompressed lip to the stem's end, m");
  v.Real("press_m", cup.press_m, {0, 1}, "compression of the bellows at the planned grasp, m");
  v.Real("bellows_npm", cup.bellows_npm, {1, 1e5}, "stiffness of the bellows until it seals, N/m");
  v.Real("lip_conform_m", cup.lip_conform_m, {0, 0.05},
         "maximum unevenness along the rim that the lip seals, m");
  v.Real("vacuum_n", cup.vacuum_n, {0.1, 5000}, "pull that breaks the seal, N");
  v.Real("moment_limit_nm", cup.moment_limit_nm, {0.001, 500},
         "bending moment that breaks the seal, Nm");
  v.Real("friction", cup.friction, {0.01, 3},
         "friction factor of the lip; multiplies the object's friction");
  v.Real("break_after_s", cup.break_after_s, {0.001, 1},
         "time over which the load is averaged before it can break the seal, s");
  v.Real("stem_radius_m", cup.stem_radius_m, kSize, "radius of the stem, m");
  v.Real("stem_length_m", cup.stem_length_m, kSize,
         "length of the stem from the bellows to the palm, m");
  v.Vector3("palm_size_m", cup.palm_size_m, kSize, "size of the box behind the stem, m");
}

void SuctionCup::Validate(const std::string& source) const {
  CheckInput(cup.press_m < cup.bellows_travel_m,
             fmt::format("{}: press_m = {}: must be below the bellows_travel_m of {}", source,
                         cup.press_m, cup.bellows_travel_m));
  const double palm_m = cup.palm_size_m.head<2>().maxCoeff();
  CheckInput(2 * cup.stem_radius_m <= palm_m,
             fmt::format("{}: stem_radius_m = {}: the stem is wider than the palm behind it, which "
                         "has {} m; lower it or raise palm_size_m",
                         source, cup.stem_radius_m, palm_m));
  const double max_n = kAirPressure_pa * std::numbers::pi * cup.radius_m * cup.radius_m;
  CheckInput(cup.vacuum_n <= max_n,
             fmt::format("{}: vacuum_n = {}: air pressure holds a cup of radius_m = {} with {:.3g} "
                         "N at most; lower it or raise radius_m",
                         source, cup.vacuum_n, cup.radius_m, max_n));
  const double max_nm = cup.vacuum_n * cup.radius_m;
  CheckInput(cup.moment_limit_nm <= max_nm,
             fmt::format("{}: moment_limit_nm = {}: a lip tips over its rim at vacuum_n times "
                         "radius_m, {:.3g} Nm; lower it",
                         source, cup.moment_limit_nm, max_nm));
}

std::array<const char*, 3> SuctionCup::axes_G() const {
  return {"x of the lip", "y of the lip", "the approach"};
}

std::string SuctionCup::Summary() const {
  return fmt::format("lip of {:.0f} mm, {:g} N, {:g} Nm", 2e3 * cup.radius_m, cup.vacuum_n,
                     cup.moment_limit_nm);
}

// Pull and moment have the same cause, the pressure in the cup.
std::shared_ptr<const Gripper> SuctionCup::WithForce(double factor) const {
  auto gripper = std::make_shared<SuctionCup>(*this);
  gripper->cup.vacuum_n *= factor;
  gripper->cup.moment_limit_nm *= factor;
  return gripper;
}

Hand& SuctionCup::AddTo(PhysicsWorld& world, double, const Pose& X_WG) const {
  return AddSuctionHand(world, cup, X_WG);
}

std::vector<AxisAlignedBox> SuctionCup::Boxes(double) const { return CupBoxes(cup); }

std::vector<AxisAlignedBox> SuctionCup::SoftBoxes() const {
  const Eigen::Vector3d half(cup.radius_m, cup.radius_m, 0.5 * cup.bellows_travel_m);
  return {{{0, 0, -half.z()}, half}};
}

double SuctionCup::WeightShare(const ObjectModel& object, const Pose& X_GO,
                               const Eigen::Vector3d& down_G) const {
  LipLoad load;
  load.force_n = WrenchForce_n(object) * down_G;
  load.torque_nm = (X_GO * object.mass.com_O).cross(load.force_n);
  return ShareOfLimit(cup, PairFriction(object.friction, cup.friction), load);
}

std::vector<GraspCandidate> SuctionCup::MakeCandidates(const ObjectModel& model, Rng& rng,
                                                       const GraspCandidateOptions& options) const {
  return SuctionGrasps(model, cup, rng, options.suction, options.robust);
}

}  // namespace pickbed::grasp
