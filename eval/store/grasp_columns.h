#pragma once

// Columns of a grasp in the results store.

#include "eval/layer.h"
#include "grasp/grasp.h"

namespace pickbed::eval {

// Calls v(column, value) for each of them.
template <typename V>
void VisitGrasp(V& v, grasp::Grasp& grasp) {
  v("grasp_hypothesis", grasp.hypothesis);
  v("grasp_x_wg", grasp.X_WG);
  v("grasp_width_m", grasp.width_m);
  v("grasp_score", grasp.score);
  v("grasp_tool", grasp.tool);
  v("grasp_lift_aside_x_m", grasp.lift_aside_m.x());
  v("grasp_lift_aside_y_m", grasp.lift_aside_m.y());
}

}  // namespace pickbed::eval
