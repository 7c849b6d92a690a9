#include "grasp/execute/retention.h"

#include "grasp/execute/pick_up.h"

namespace pickbed::grasp {
namespace {

Eigen::Vector3d LateralDirection_W(const Pose& X_WG) {
  const Eigen::Vector3d across_W = X_WG.linear().col(0).cross(Eigen::Vector3d::UnitZ());
  if (across_W.norm() > 1e-3) return across_W.normalized();
  return X_WG.linear().col(1);  // the hand closes along the vertical
}

}  // namespace

void RetentionOptions::Visit(SettingsVisitor& v) {
  v.Real("max_g", max_g, {0, 1000},
         "largest load of the hold test after a successful pick, multiples of g; 0 = no test");
  v.Real("g_per_s", g_per_s, {0.01, 1000}, "growth of the load, multiples of g per second");
  v.Bool("is_lateral", is_lateral,
         "whether a horizontal load across the closing direction grows; else the weight");
}

double Retention_g(const Scene& scene, const ObjectSet& objects, const Grasp& grasp,
                   const Gripper& gripper, const GraspTarget& target,
                   const ExecuteOptions& options) {
  const MotionListener no_listener;
  PickUp pick(scene, objects, grasp, gripper, target, options, no_listener);
  GraspOutcome outcome;
  if (pick.Run(outcome) != FailureReason::kNone) return 0;
  const int picked = pick.PickedOf(pick.Held());
  if (picked < 0) return 0;
  const RetentionOptions& retention = options.retention;
  const Eigen::Vector3d& gravity_W = options.physics.gravity_W;
  const Eigen::Vector3d one_g_W =
      retention.is_lateral ? gravity_W.norm() * LateralDirection_W(pick.hand().X_WG()) : gravity_W;
  const double first_g = retention.is_lateral ? 0 : 1;
  const int steps = pick.world().Steps((retention.max_g - first_g) / retention.g_per_s);
  for (int i = 1; i <= steps; ++i) {
    const double load_g = first_g + (retention.max_g - first_g) * i / steps;
    Eigen::Vector3d load_W = load_g * one_g_W;
    if (retention.is_lateral) load_W += gravity_W;
    pick.world().physics().SetGravityOf(picked, load_W);
    pick.Advance(pick.Lifted());
    if (!pick.hand().Holds() || !pick.IsInHand(picked)) return load_g;
  }
  return retention.max_g;
}

}  // namespace pickbed::grasp
