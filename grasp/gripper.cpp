#include "grasp/gripper.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "grasp/grippers/parallel_jaw.h"
#include "scenes/check.h"
#include "scenes/object_catalog.h"

namespace pickbed {
namespace {

// A size of zero would make a hand that touches nothing; a tenth of a millimetre is below any
// gripper that is built.
constexpr double kSmallestSize_m = 1e-4;
constexpr double kLargestSize_m = 1.0;

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
  const Range size{kSmallestSize_m, kLargestSize_m};
  v.Text("mechanism", mechanism, MechanismNames(), "how the hand closes");
  v.Vector3("finger_size_m", hand.finger_size_m, size,
            "x thickness, y width, z length of a finger");
  v.Vector3("palm_size_m", hand.palm_size_m, size, "box behind the fingers");
  v.Real("stroke_m", hand.stroke_m, size, "largest opening between the pads, m");
  v.Real("finger_mass_kg", hand.finger_mass_kg, {0.001, 10}, "of each finger, kg");
  v.Real("force_n", hand.force_n, {0.1, 2000}, "of each finger on the part, N");
  v.Real("close_speed_mps", hand.close_speed_mps, {0.001, 1}, "of each finger, m/s");
  v.Real("pad_friction", hand.pad_friction, {0.01, 3}, "of a pad; multiplies the part's own value");
  v.Real("approach_m", approach_m, {0.01, 1}, "straight-line approach before the grasp, m");
  v.Real("clearance_m", clearance_m, {0, 0.05}, "kept between hand and anything else, m");
}

std::span<const MechanismRow> MechanismTable() {
  static constexpr std::array<MechanismRow, 1> kTable{{
      {"parallel_jaw", "two coupled fingers on a slider with a force limit", CheckParallelJaw,
       ParallelJawApproachOpening},
  }};
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

}  // namespace pickbed
