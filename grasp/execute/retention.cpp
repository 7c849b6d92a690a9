#include "grasp/execute/retention.h"

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

double LoadUntilLost_g(AttemptWorld& world, const Hand& hand, int position,
                       const RetentionOptions& options, const Eigen::Vector3d& gravity_W,
                       const std::function<void()>& step, const std::function<bool()>& is_lost) {
  const Eigen::Vector3d one_g_W =
      options.is_lateral ? gravity_W.norm() * LateralDirection_W(hand.X_WG()) : gravity_W;
  const double first_g = options.is_lateral ? 0 : 1;
  const int steps = world.Steps((options.max_g - first_g) / options.g_per_s);
  for (int i = 1; i <= steps; ++i) {
    const double load_g = first_g + (options.max_g - first_g) * i / steps;
    Eigen::Vector3d load_W = load_g * one_g_W;
    if (options.is_lateral) load_W += gravity_W;
    world.physics().SetGravityOf(position, load_W);
    step();
    if (is_lost()) return load_g;
  }
  return options.max_g;
}

}  // namespace pickbed::grasp
