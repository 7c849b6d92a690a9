#pragma once

// Columns of the drawn errors of a cell (eval/cell/cell_errors.h), for the rows of the results
// store.

#include "eval/cell/cell_errors.h"

namespace pickbed::eval {

template <typename V>
void VisitErrors(V& v, BinErrors& errors) {
  v("hand_eye_x_m", errors.hand_eye_m.x());
  v("hand_eye_y_m", errors.hand_eye_m.y());
  v("hand_eye_z_m", errors.hand_eye_m.z());
  v("hand_eye_rx_rad", errors.hand_eye_rotation_rad.x());
  v("hand_eye_ry_rad", errors.hand_eye_rotation_rad.y());
  v("hand_eye_rz_rad", errors.hand_eye_rotation_rad.z());
  v("focal_error", errors.focal);
  v("principal_x_px", errors.principal_px.x());
  v("principal_y_px", errors.principal_px.y());
  v("depth_bias_m", errors.depth_bias_m);
  v("depth_scale_error", errors.depth_scale);
  v("bin_x_m", errors.bin_m.x());
  v("bin_y_m", errors.bin_m.y());
  v("bin_z_m", errors.bin_m.z());
  v("bin_rx_rad", errors.bin_rotation_rad.x());
  v("bin_ry_rad", errors.bin_rotation_rad.y());
  v("bin_rz_rad", errors.bin_rotation_rad.z());
}

template <typename V>
void VisitErrors(V& v, AttemptErrors& errors) {
  v("robot_x_m", errors.robot_m.x());
  v("robot_y_m", errors.robot_m.y());
  v("robot_z_m", errors.robot_m.z());
  v("force_error", errors.force);
}

}  // namespace pickbed::eval
