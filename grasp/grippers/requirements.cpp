#include "grasp/grippers/requirements.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "grasp/grippers/table.h"
#include "scenes/base/error.h"
#include "scenes/objects/contact.h"

namespace pickbed::grasp {
namespace {

// Returns a gripper that can hold the object, for example "jaw_14cm has 12 grasps"; empty if there
// is none. Tries grippers that need the same of an object first, and names only one, because the
// candidates of each gripper take seconds.
std::string OtherGripper(const ObjectModel& object, const Gripper& gripper,
                         GraspCandidateOptions options) {
  // A lower limit, for example of a table to print, must not make the grippers look alike.
  const GraspCandidateOptions usual;
  options.antipodal.candidates = std::max(options.antipodal.candidates, usual.antipodal.candidates);
  options.antipodal.resting_candidates =
      std::max(options.antipodal.resting_candidates, usual.antipodal.resting_candidates);
  options.suction.candidates = std::max(options.suction.candidates, usual.suction.candidates);
  std::vector<std::shared_ptr<const Gripper>> others;
  for (const std::string& name : GripperNames()) {
    if (name != gripper.name) others.push_back(LoadGripper(name));
  }
  std::stable_partition(others.begin(), others.end(), [&](const auto& other) {
    return std::string_view(other->needs()) == gripper.needs();
  });
  for (const auto& other : others) {
    if (!CanCarry(*other, object.mass.mass_kg, object.friction)) continue;
    const size_t count = CachedCandidates(object, *other, options).size();
    if (count > 0) return fmt::format("{} has {} grasps", other->name, count);
  }
  return {};
}

}  // namespace

void RequireFitsBin(const Gripper& gripper, const Bin& bin) {
  if (bin.inner_size_m.z() <= 0) return;
  Eigen::AlignedBox2d inside;
  for (const AxisAlignedBox& box : gripper.Boxes(0)) {
    const double above_floor_m = -(box.center.z() + box.half_size.z());
    if (above_floor_m >= bin.inner_size_m.z()) continue;
    inside.extend(Eigen::Vector2d((box.center - box.half_size).head<2>()));
    inside.extend(Eigen::Vector2d((box.center + box.half_size).head<2>()));
  }
  const Eigen::Vector2d hand = inside.sizes(), room = bin.inner_size_m.head<2>();
  const bool fits =
      (hand.array() <= room.array()).all() || (hand.reverse().array() <= room.array()).all();
  CheckInput(
      fits,
      fmt::format("gripper '{}' is wider than the bin: {:.0f} x {:.0f} mm of it must fit between "
                  "walls {:.0f} x {:.0f} mm apart; use a smaller gripper or a larger bin",
                  gripper.name, 1e3 * hand.x(), 1e3 * hand.y(), 1e3 * room.x(), 1e3 * room.y()));
}

bool CanCarry(const Gripper& gripper, double mass_kg, double friction) {
  return mass_kg * kGravity_mps2 < gripper.Capacity_n(friction);
}

void RequireCanCarry(const Gripper& gripper, const ObjectModel& object) {
  const double capacity_n = gripper.Capacity_n(object.friction);
  const double weight_n = object.mass.mass_kg * kGravity_mps2;
  CheckInput(
      CanCarry(gripper, object.mass.mass_kg, object.friction),
      fmt::format(
          "object '{}' is too heavy for gripper '{}': it weighs {:.3g} kg, {:.3g} N, and the "
          "gripper carries at most {:.3g} N of it ({}, friction {:g}); use a stronger gripper",
          object.name, gripper.name, object.mass.mass_kg, weight_n, capacity_n, gripper.Summary(),
          object.friction));
}

bool OpensFor(const Gripper& gripper, double width_m) {
  constexpr double kRounding_m = 1e-6;
  return gripper.MaxOpening_m() <= 0 || width_m <= gripper.MaxOpening_m() + kRounding_m;
}

void RequireOpensFor(const Gripper& gripper, double width_m) {
  CheckInput(OpensFor(gripper, width_m),
             fmt::format("width_m = {:.4g}: gripper {} opens at most {:.4g} m", width_m,
                         gripper.name, gripper.MaxOpening_m()));
}

std::vector<GraspCandidate> RequireCandidates(const ObjectModel& object, const Gripper& gripper,
                                              const GraspCandidateOptions& options) {
  auto candidates = CachedCandidates(object, gripper, options);
  if (!candidates.empty()) return candidates;
  const std::string other = OtherGripper(object, gripper, options);
  throw InputError(fmt::format(
      "object '{}' has no {} for gripper '{}', {}", object.name, gripper.needs(), gripper.name,
      other.empty() ? "and no other shipped gripper can hold it"
                    : fmt::format("but {}; compare grippers with `pickbed grasps {} GRIPPER`",
                                  other, object.name)));
}

}  // namespace pickbed::grasp
