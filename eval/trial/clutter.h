#pragma once

// How cluttered a bin is: fill level, layers, visibility, and how many instances can be grasped.

#include <vector>

#include "eval/trial/trial_setup.h"
#include "scenes/scene.h"

namespace pickbed::eval {

struct ClutterStatistics {
  int instances = 0;
  double fill_level = 0;                 // see sim/drop/fill_level.h
  std::vector<int> layers;               // instances in each layer, from the top
  std::vector<double> visible_fraction;  // of each wanted instance
  int counted = 0;                       // wanted instances with at least kCountedVisibility
  int graspable = 0;  // counted instances with a grasp that meets nothing, at the true poses
};

// Measures a scene of the setup's cell in the view of its camera. All instances at their true poses
// are obstacles for the planned grasps.
ClutterStatistics MeasureClutter(const TrialSetup& setup, const Scene& scene, BinIndex bin_index,
                                 const Observation& view);

}  // namespace pickbed::eval
