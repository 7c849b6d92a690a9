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
  v.Real("min_score", min_score, {0, 1},
         "smallest score of a grasp that is executed; without such a grasp, the bin is stirred or "
         "ends");
  v.Text(
      "segmentation", segmentation, {},
      "method that finds the objects in an image (see pickbed segment --help); only for planners "
      "completed and skirt");
  v.Text(
      "completion", completion, {},
      "method that completes the shapes of objects, model file of `pickbed train completion`, or "
      "truth for the true shapes; only for planner completed");
  v.Text(
      "success_model", success_model, {},
      "network that estimates the chance of success of a jaw's grasp, a name in assets/models or "
      "a file, or none for a logistic function; only for planners completed and skirt");
  v.Integer("rehearsals", rehearsals, {0, 100000},
            "maximum number of grasps of an image that are rehearsed in physics on the completed "
            "shapes, only by jaws; 0 = none; only for planners completed and skirt");
  v.Words("command", command,
          "program that plans the grasps, and its arguments; only for planners process and "
          "process_poses");
  v.Text("connect", connect, {},
         "address host:port of a program that plans the grasps, instead of a command; only for "
         "planners process and process_poses");
  v.Real("timeout_s", timeout_s, {0.01, 86400},
         "maximum time for each answer of the program, s; only for planners process and "
         "process_poses");
}

}  // namespace pickbed::scenes
