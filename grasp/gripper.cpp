#include "grasp/gripper.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <filesystem>

#include "grasp/grippers/parallel_jaw.h"
#include "grasp/grippers/suction_cup.h"
#include "grasp/robust.h"
#include "scenes/check.h"
#include "scenes/object_catalog.h"

namespace pickbed {
namespace {

std::vector<std::string> MechanismNames() {
  std::vector<std::string> names;
  for (const MechanismRow& row : MechanismTable()) names.push_back(row.name);
  return names;
}

std::filesystem::path GripperFile(const std::string& name_or_path) {
  if (std::filesystem::path(name_or_path).extension() == ".yaml") return name_or_path;
  const std::vector<std::string> names = GripperNames();
  CheckInput(std::find(names.begin(), names.end(), name_or_path) != names.end(),
             UnknownNameMessage("gripper", name_or_path, names));
  return AssetsDir() / "grippers" / (name_or_path + ".yaml");
}

}  // namespace

void GripperSpec::Visit(SettingsVisitor& v) {
  v.Text("mechanism", mechanism, MechanismNames(), "how the hand holds");
  MechanismOf(*this).visit(*this, v);
  v.Real("approach_m", approach_m, {0.01, 1}, "straight-line approach before the grasp, m");
  v.Real("clearance_m", clearance_m, {0, 0.05}, "kept between hand and anything else, m");
}

std::span<const MechanismRow> MechanismTable() {
  static const std::array<MechanismRow, 2> kTable{ParallelJawRow(), SuctionCupRow()};
  return kTable;
}

const MechanismRow& MechanismOf(const GripperSpec& spec) {
  for (const MechanismRow& row : MechanismTable()) {
    if (spec.mechanism == row.name) return row;
  }
  throw InputError(UnknownNameMessage("mechanism", spec.mechanism, MechanismNames()));
}

GripperSpec LoadGripper(const std::string& name_or_path) {
  const std::filesystem::path file = GripperFile(name_or_path);
  GripperSpec spec;
  spec.name = file.stem().string();
  ReadSettingsFile(file, [&](SettingsVisitor& v) { spec.Visit(v); });
  MechanismOf(spec).check(spec, file.string());
  return spec;
}

std::vector<std::string> GripperNames() { return StemsIn(AssetsDir() / "grippers", ".yaml"); }

void RequireFitsBin(const GripperSpec& gripper, const Bin& bin) {
  if (bin.inner_size_m.z() <= 0) return;
  Eigen::AlignedBox2d inside;
  for (const AxisAlignedBox& box : MechanismOf(gripper).boxes(gripper, 0)) {
    const double above_floor_m = -(box.center.z() + box.half_size.z());
    if (above_floor_m >= bin.inner_size_m.z()) continue;
    inside.extend(Eigen::Vector2d((box.center - box.half_size).head<2>()));
    inside.extend(Eigen::Vector2d((box.center + box.half_size).head<2>()));
  }
  const Eigen::Vector2d hand = inside.sizes(), room = bin.inner_size_m.head<2>();
  const bool fits =
      (hand.array() <= room.array()).all() || (hand.reverse().array() <= room.array()).all();
  CheckInput(fits, fmt::format("gripper '{}' is wider than the bin: {:.0f} x {:.0f} mm of it must "
                               "go between walls {:.0f} x {:.0f} mm apart; take a smaller gripper "
                               "or a larger bin",
                               gripper.name, 1e3 * hand.x(), 1e3 * hand.y(), 1e3 * room.x(),
                               1e3 * room.y()));
}

void RequireCanCarry(const GripperSpec& gripper, const ObjectModel& part) {
  const double capacity_n = MechanismOf(gripper).capacity_n(gripper, part.friction);
  const double weight_n = WrenchForce_n(part);
  CheckInput(weight_n < capacity_n,
             fmt::format("part '{}' is too heavy for gripper '{}': it weighs {:.3g} kg, {:.3g} N, "
                         "and the gripper carries at most {:.3g} N of it ({}, friction {:g}); take "
                         "a stronger gripper",
                         part.name, gripper.name, part.mass.mass_kg, weight_n, capacity_n,
                         MechanismOf(gripper).summary(gripper), part.friction));
}

}  // namespace pickbed
