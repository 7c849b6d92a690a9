#pragma once

// Grippers are data: assets/grippers/NAME.yaml names a mechanism and its numbers.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scenes/settings.h"
#include "sim/hand_joints.h"

namespace pickbed {

struct GripperSpec {
  std::string name;
  std::string mechanism = "parallel_jaw";
  HandSpec hand;
  double approach_m = 0.12;    // straight-line approach before the grasp
  double clearance_m = 0.003;  // kept between hand and anything else when planning
  void Visit(SettingsVisitor& v);
};

// A way to build a hand from HandSpec's numbers: one file in grippers/ and one row in gripper.cpp.
struct MechanismRow {
  const char* name;
  const char* help;
  // Throws InputError naming `source` when the numbers contradict each other.
  void (*check)(const GripperSpec& spec, const std::string& source);
  // How far the hand is open on approach to a part of this width, m; nullopt = it cannot take it.
  std::optional<double> (*approach_opening_m)(const GripperSpec& spec, double width_m);
};

std::span<const MechanismRow> MechanismTable();

// The row of the spec's mechanism; InputError for one that is not known.
const MechanismRow& MechanismOf(const GripperSpec& spec);

// NAME of assets/grippers or a path ending in .yaml. Throws InputError for an unknown name (with
// the nearest), a force or size that is not positive, or a mechanism that is not known.
GripperSpec LoadGripper(const std::string& name_or_path);
std::vector<std::string> GripperNames();

}  // namespace pickbed
