#pragma once

// Hold test of a successful pick: how many times its weight an instance can weigh until the hand
// loses it. The attempt is repeated up to the shake. Then the load grows steadily.

#include "grasp/gripper.h"
#include "scenes/base/settings.h"
#include "scenes/scene.h"

namespace pickbed::grasp {

struct ExecuteOptions;  // grasp/execute/execute.h
struct Grasp;           // grasp/grasp.h
struct GraspTarget;     // grasp/execute/execute.h

// Options of the hold test.
struct RetentionOptions {
  double max_g = 0;    // largest load, multiples of g; 0 = no test
  double g_per_s = 2;  // growth of the load; slower is more exact and takes longer
  // Whether a horizontal load grows beside the constant weight. It acts across the closing
  // direction, in which only friction holds. Else the weight itself grows, from 1 g on.
  bool is_lateral = false;
  void Visit(SettingsVisitor& v);
};

// Repeats the pick-up with the hold test options.retention. Arguments as in ExecuteGrasp(). Returns
// the load at which the instance left the hand, in multiples of g: 0 if no instance is in the hand
// after the shake, and RetentionOptions::max_g if the hand held it to the end.
double Retention_g(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                   const Gripper& gripper, const GraspTarget& target,
                   const ExecuteOptions& options);

}  // namespace pickbed::grasp
