#pragma once

// Grippers are data: assets/grippers/NAME.yaml names a mechanism and its numbers.

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

// NAME of assets/grippers or a path ending in .yaml. Throws InputError for an unknown name (with
// the nearest), a force or size that is not positive, or a mechanism that is not known.
GripperSpec LoadGripper(const std::string& name_or_path);
std::vector<std::string> GripperNames();

}  // namespace pickbed
