#pragma once

// The group `planner` of a scenario: the grasp planner and its settings. The planners are the rows
// of PlannerTable() in grasp/planners/table.h.

#include <string>
#include <vector>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// Name of the planner that moves grasp candidates of known objects to estimated poses.
inline constexpr char kPosePlanner[] = "poses";

// Value of PlannerSpec::success_model for a logistic function in place of a network.
inline constexpr char kNoSuccessModel[] = "none";

struct PlannerSpec {
  std::string name = kPosePlanner;  // a row of PlannerTable()
  // For planners without poses, which know no object.
  double friction = 0.4;     // assumed coefficient between a pad and an unknown object
  double max_tilt_deg = 30;  // of the approach from straight down
  double min_score = 0;      // weaker grasps are not executed
  // For planners on completed shapes: how objects are found, how their shapes are completed, and
  // how grasps are rated.
  std::string segmentation = "convexity";
  std::string completion = "network";
  std::string success_model = kNoSuccessModel;  // network that rates grasps of a jaw
  int rehearsals = 0;  // maximum number of grasps of an image that are rehearsed in physics
  // For planners that are programs: `command` or `connect`.
  std::vector<std::string> command;  // program and arguments
  std::string connect;               // host:port of a running program
  double timeout_s = 60;             // maximum time for each answer
  void Visit(SettingsVisitor& v);
};

}  // namespace pickbed::scenes
