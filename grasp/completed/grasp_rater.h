#pragma once

// Measures planned grasps of the unknown objects in one image, for their chance of success.

#include <span>
#include <vector>

#include "grasp/completed/grasped_segment.h"
#include "grasp/completed/hand_surroundings.h"
#include "grasp/completed/occupancy_shape.h"
#include "grasp/completed/success_chance.h"
#include "grasp/completed/success_network.h"
#include "grasp/plan/hidden_space.h"
#include "grasp/plan/plan.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

class GraspRater {
 public:
  // References must outlive the object.
  // - X_WB: pose of the bin, or of the table under the objects
  // - shapes: completed shapes of the objects in the image
  // - plan: gives the distances of the hidden space
  GraspRater(const PlannerInput& input, const Pose& X_WB, const ImageSegments& segments,
             std::span<const OccupancyShape> shapes, const PlanOptions& plan);

  const HiddenSpace& hidden() const { return hidden_; }

  // Returns the measures of a grasp in W by a tool. `surface` is the one on which it was planned.
  GraspMeasures Measure(const Grasp& grasp, const Gripper& tool, GraspedSurface surface) const;

  // Returns the inputs of a network for a jaw's grasp: kSuccessInputs values.
  std::vector<float> Inputs(const Grasp& grasp, const Gripper& tool, GraspedSurface surface) const;

 private:
  const SegmentMeasures* SegmentOf(const Grasp& grasp, const Gripper& tool) const;
  // `segment`: the grasped one; null = none
  GraspMeasures MeasureOn(const SegmentMeasures* segment, const Grasp& grasp, const Gripper& tool,
                          GraspedSurface surface) const;

  const PlannerInput& input_;
  const ImageSegments& segments_;
  const PlanOptions& plan_;
  const Pose X_BW_;
  const HiddenSpace hidden_;
  const HandSurroundings surroundings_;
};

}  // namespace pickbed::grasp
