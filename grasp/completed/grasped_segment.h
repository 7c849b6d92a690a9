#pragma once

// The segment of an unknown object under a grasp: how much others cover it, and where its center
// is.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "grasp/plan/planner.h"
#include "scenes/image/image.h"

namespace pickbed::grasp {

// What a planner knows about a segment.
struct SegmentMeasures {
  double covered =
      0;  // share of its contour beyond which the surface is nearer to the camera, 0..1
  Eigen::Vector3d center_C = Eigen::Vector3d::Zero();  // mean of its points, m
};

// Segments of the unknown objects in an image.
struct ImageSegments {
  Image<uint16_t> labels;                 // 0 = no segment; else index of the segment + 1
  std::vector<SegmentMeasures> segments;  // empty = unknown
  int without_shape = 0;  // tried segments that got no shape, for example with few readings
};

// Returns the segment with the most readings between the fingers, or at the center of a hand
// without fingers. Returns null if there is none.
// - X_WG: pose of the grasp; width_m: distance between its contacts
const SegmentMeasures* GraspedSegment(const ImageSegments& image, const PlannerInput& input,
                                      const Gripper& tool, const Pose& X_WG, double width_m);

// Returns the horizontal distance of the segment's center from the closing line of a hand, the x
// axis of G through its origin, m. The weight of the object turns it about this line.
double CenterOffset_m(const SegmentMeasures& segment, const Pose& X_WC, const Pose& X_WG);

}  // namespace pickbed::grasp
