#pragma once

// Errors of a cell: a group of a scenario's settings. A real cell knows its camera, its bin and its
// parts only with an error. Each setting is the standard deviation of one such error; 0 = none. The
// true scene does not change, unless the setting says so. eval/cell/cell_errors.h draws the values
// and applies them.

#include <Eigen/Core>
#include <functional>
#include <string>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// Standard deviations. Deviates are normal and limited to kMaxDeviate. Positions have one deviate
// for each axis. Rotations are about a random axis.
struct CellErrorsSpec {
  static constexpr double kMaxDeviate = 3;  // in standard deviations

  // Once per bin: what the cell assumes.
  double hand_eye_mm = 0;  // position of the camera, in C
  double hand_eye_deg = 0;
  double focal_percent = 0;  // of the focal length
  double principal_px = 0;
  double depth_bias_mm = 0;        // added to each depth reading
  double depth_scale_percent = 0;  // of each depth reading
  double bin_mm = 0;               // position of the bin, in W
  double bin_deg = 0;
  // Once per attempt: what the robot does.
  double repeatability_mm = 0;  // position of the executed grasp, in W
  double force_percent = 0;     // of the gripper's force
  // What the bin holds.
  double friction_percent = 0;  // of each instance
  double mass_percent = 0;      // of each instance
  double size_percent = 0;      // of all instances of one object in a bin
  void Visit(SettingsVisitor& v);

  // Returns whether every error is 0.
  bool off() const;

  // Throws InputError if an error displaces instances by more than the width of the bin.
  // - bin_inner_size_m: length, width and height
  // - distance_m: from the camera to the bin
  // - focal_px: focal length of the camera
  // - at: converts a key such as "hand_eye_mm" into its name in the message
  void Validate(const Eigen::Vector3d& bin_inner_size_m, double distance_m, double focal_px,
                const std::function<std::string(const std::string& key)>& at) const;
};

// Returns the errors that are not 0, such as "hand_eye_mm 1, repeatability_mm 0.02"; empty if all
// are 0.
std::string CellErrorsInWords(const CellErrorsSpec& spec);

}  // namespace pickbed::scenes
