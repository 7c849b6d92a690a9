#include "grasp/execute/stir.h"

#include <cmath>

#include "grasp/place/hand_motion.h"
#include "scenes/base/error.h"
#include "sim/hands/hand.h"

namespace pickbed::grasp {

void StirOptions::Visit(SettingsVisitor& v) {
  v.Real("speed_mps", speed_mps, {0.001, 10}, "peak speed of the hand, m/s");
  v.Real("settle_s", settle_s, {0, 100}, "maximum time until the instances sleep again, s");
}

ExecuteResult StirBin(const Scene& scene, const ObjectSet& objects, const Gripper& gripper,
                      const StirPath& path, const StirOptions& options,
                      const PhysicsOptions& physics, const MotionListener& on_step) {
  CheckSettings("StirOptions", options);
  CheckInput(path.X_WG_from.matrix().allFinite() && path.X_WG_to.matrix().allFinite() &&
                 std::isfinite(path.rise_m),
             "the path of the stir is not finite");
  AttemptWorldOptions all_move;
  all_move.all_active = true;
  AttemptWorld world(scene, objects, path.X_WG_from, {}, {0, 0}, kNoInstance, all_move, physics);
  const auto raised = [&](const Pose& X_WG) { return Translation({0, 0, path.rise_m}) * X_WG; };
  Hand& hand = gripper.AddTo(world.physics(), 0, raised(path.X_WG_from));
  hand.HoldOpening(0);
  int steps = 0;
  const auto step = [&] {
    world.Step();
    ++steps;
    if (on_step) on_step({steps * world.physics().step_s(), world, hand, nullptr});
  };
  const auto move = [&](const Pose& from, const Pose& to) {
    const double distance_m = (to.translation() - from.translation()).norm();
    const int count = world.Steps(MinimumJerkSeconds(distance_m, options.speed_mps));
    for (int i = 1; i <= count; ++i) {
      hand.MoveTo(Between(from, to, MinimumJerk(static_cast<double>(i) / count)));
      step();
    }
  };
  move(raised(path.X_WG_from), path.X_WG_from);
  move(path.X_WG_from, path.X_WG_to);
  move(path.X_WG_to, raised(path.X_WG_to));
  const int maximum = world.Steps(options.settle_s);
  for (int i = 0; i < maximum && !world.physics().AllAsleep(); ++i) {
    hand.MoveTo(raised(path.X_WG_to));
    step();
  }
  ExecuteResult result;
  const bool failed = world.physics().BlewUp();
  result.outcome.failure = failed ? FailureReason::kPhysicsFailed : FailureReason::kStirred;
  result.after = failed ? scene : world.Remaining({});
  if (!failed) {
    result.outcome.neighbors_displaced =
        world.Displaced(ExecuteOptions().displaced_m, {}, kNoInstance);
  }
  return result;
}

}  // namespace pickbed::grasp
