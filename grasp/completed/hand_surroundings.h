#pragma once

// What an image shows around a hand: inputs of a network that rates grasps.
//
// Cells with an edge of 5 mm in front of the hand, in its frame G, are joined to regions:
//
//      far   near  finger  inside  finger  near   far      regions along x, the closing direction;
//   |       |     |  ||  |        |  ||  |     |       |   they move with the fingers
//           25    10     -4 mm  center   (distance from the inner side of a finger)
//
// - along y, by distance from the center: the pad, beside the hand, far beside it
// - along z, the approach direction: six layers from 50 mm above the finger tips to 30 mm below
//
// A grasp that is turned by half a turn about z is the same grasp, so both sides of a region give
// their mean and the size of their difference.

#include <span>
#include <vector>

#include "grasp/completed/grasped_segment.h"
#include "grasp/completed/occupancy_shape.h"
#include "grasp/plan/planner.h"

namespace pickbed::grasp {

// Number of values: 4 x 3 x 6 regions, three quantities, mean and difference.
inline constexpr int kSurroundingsValues = 4 * 3 * 6 * 3 * 2;

class HandSurroundings {
 public:
  // References must outlive the object.
  // - shapes: completed shapes of the objects in the image
  HandSurroundings(const PlannerInput& input, const ImageSegments& segments,
                   std::span<const OccupancyShape> shapes);

  // Returns kSurroundingsValues values of a hand. For each region (x slowest, then y and z):
  // - distance from the observed surface along the rays of the camera, in units of 20 mm, at most 1
  //   above the surface and at least -1 below it; 0 without a reading
  // - share of the cells below the surface of other segments
  // - probability of the completed shapes
  // `X_WG` is the pose of the hand and `opening_m` the distance between its open fingers. `own` is
  // the grasped segment, one of `segments`; null = none.
  std::vector<float> Of(const Pose& X_WG, double opening_m, const SegmentMeasures* own) const;

 private:
  const PlannerInput& input_;
  const ImageSegments& segments_;
  std::span<const OccupancyShape> shapes_;
  std::vector<Pose> X_VW_;  // of each shape
};

}  // namespace pickbed::grasp
