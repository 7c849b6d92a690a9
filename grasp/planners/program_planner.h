#pragma once

// Planners that are programs: rows `process` and `process_poses` of the table. The program gets the
// image and, in the second row, the estimated poses (docs/pages/reference/plugin_protocol.md).

#include "grasp/plan/planner.h"
#include "grasp/plan/process_planner.h"

namespace pickbed::grasp {

class ProgramPlanner : public Planner {
 public:
  // `gives_poses`: the program gets the objects and the estimated poses, and each of its grasps
  // must name a pose. Throws InputError if the program does not start or plans no grasps.
  ProgramPlanner(const PlannerSetup& setup, bool gives_poses);

  // A program that fails gives no grasps, but PlanResult::failure. The next call starts it again.
  PlanResult Plan(const PlannerInput& input) override;

 private:
  const bool gives_poses_;
  ProcessPlanner program_;
};

}  // namespace pickbed::grasp
