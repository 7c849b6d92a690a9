#pragma once

// Hold test of a successful pick: how many times its weight an instance can weigh until the hand
// loses it. The attempt is repeated up to the shake. Then the load grows steadily.

#include <Eigen/Core>
#include <functional>

#include "grasp/execute/attempt_world.h"
#include "scenes/base/settings.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {

// Options of the hold test.
struct RetentionOptions {
  double max_g = 0;    // largest load, multiples of g; 0 = no test
  double g_per_s = 2;  // growth of the load; slower is more exact and takes longer
  // Whether a horizontal load grows beside the constant weight. It acts across the closing
  // direction, in which only friction holds. Else the weight itself grows, from 1 g on.
  bool is_lateral = false;
  void Visit(SettingsVisitor& v);
};

// Holds the hand still at its pose and increases the load on the instance at `position` of the
// world until `is_lost`. Returns the load at that time in multiples of g; RetentionOptions::max_g
// if the instance is not lost. `step` advances the world by one step with the hand at rest.
double LoadUntilLost_g(AttemptWorld& world, const Hand& hand, int position,
                       const RetentionOptions& options, const Eigen::Vector3d& gravity_W,
                       const std::function<void()>& step, const std::function<bool()>& is_lost);

}  // namespace pickbed::grasp
