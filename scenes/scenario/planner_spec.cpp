#include "scenes/scenario/planner_spec.h"

namespace pickbed::scenes {

void PlannerSpec::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "name of the grasp planner, a row of `pickbed list planners`");
  v.Real("friction", friction, {0.05, 2},
         "assumed friction coefficient between a pad and an unknown object; only for planners "
         "without poses");
  v.Real("max_tilt_deg", max_tilt_deg, {0, 80},
         "maximum angle of the approach from straight down, degrees; only for planners without "
         "poses");
}

}  // namespace pickbed::scenes
