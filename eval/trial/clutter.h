#pragma once

// How cluttered a bin is: fill level, layers, visibility, and how many instances can be grasped.

#include <span>
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
  // Counted instances for which a grasp was planned at the true poses, and those with a grasp that
  // meets nothing.
  int tested = 0, graspable = 0;
};

// Returns the number of instances in each layer, from the top. `layers`: layer of each instance.
std::vector<int> CountsByLayer(std::span<const int> layers);

struct GraspableCount {
  int tested = 0, graspable = 0;
};

// Counts the graspable ones among wanted instances that are at least kCountedVisibility visible: a
// grasp meets nothing. All instances at their true poses are obstacles. Without a pose stage there
// are no grasp candidates, so none is tested.
// - visible_fractions: by scene.objects
// - max_tested: of more instances, so many are tested, evenly spread over their order
GraspableCount CountGraspable(const TrialSetup& setup, const Scene& scene,
                              std::span<const double> visible_fractions, int max_tested);

// Measures a scene of a cell in the view of its camera. No instance is tested for a grasp.
ClutterStatistics MeasureClutter(const SimulatedCell& cell, const Scene& scene, BinIndex bin_index,
                                 const Observation& view);

}  // namespace pickbed::eval
