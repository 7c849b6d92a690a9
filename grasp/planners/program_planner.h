#pragma once

// Planners that are programs, in any language: rows `process` and `process_poses` of the table. A
// program is a child process or a server (scenes/plugin). It gets the image and, in the second row,
// the estimated poses (docs/pages/reference/plugin_protocol.md).

#include <vector>

#include "grasp/plan/planner.h"
#include "scenes/plugin/plugin_client.h"
#include "scenes/plugin/plugin_messages.h"

namespace pickbed::grasp {

class ProgramPlanner : public Planner {
 public:
  // `gives_poses`: the program gets the objects and the estimated poses, and each of its grasps
  // must name a pose. Throws InputError if the program does not start or plans no grasps.
  ProgramPlanner(const PlannerSetup& setup, bool gives_poses);

  // A program that fails gives no grasps, but PlanResult::failure. The next call starts it again.
  // Throws InputError if the image lacks what the program needs.
  PlanResult Plan(const PlannerInput& input) override;

  const PluginIdentity& identity() const { return client_.identity(); }

 private:
  void RequireNeeds(const PlannerInput& input) const;
  std::vector<Grasp> Ask(const PlannerInput& input);

  const bool gives_poses_;
  ObjectSet objects_;                    // the setup message refers to them; none without poses
  std::vector<PluginGripper> grippers_;  // as the program knows them
  PluginClient client_;
};

}  // namespace pickbed::grasp
