#pragma once

// Table of the grasp planners. A new planner is one row in table.cpp.

#include <memory>
#include <span>
#include <string>

#include "grasp/plan/planner.h"

namespace pickbed::grasp {

// A planner: name, one line of help, and the function that makes it.
struct PlannerRow {
  const char* name;
  const char* help;
  bool needs_poses;  // false: a trial has no pose stage, and the planner gets no object
  std::unique_ptr<Planner> (*make)(const PlannerSetup& setup);
  bool needs_shapes = false;         // PlannerSetup::shapes must be set
  const char* completion = nullptr;  // method of these shapes; null = PlannerSpec::completion
};
// Returns all planners, in the order of the help.
std::span<const PlannerRow> PlannerTable();
// Returns the row with this name. Throws InputError that lists the known names.
const PlannerRow& PlannerNamed(const std::string& name);

}  // namespace pickbed::grasp
