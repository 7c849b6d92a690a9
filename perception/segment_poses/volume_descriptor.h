#pragma once

// Descriptor of a completed volume: its occupancy on a coarse grid in a frame that follows the
// object.
//
// The frame F has its origin at the center of the probable matter. Its z axis has the direction of
// the ray from the camera. The grid is as large as the object, not as large as what is seen, so an
// occluder changes it little:
//
//      C                     +-------+
//       \                    |  ___  |
//        `---- ray --------> | |_F_| | z
//                            +-------+

#include <optional>
#include <vector>

#include "perception/completion/completed_volume.h"
#include "scenes/geometry/pose.h"

namespace pickbed::perception {

inline constexpr int kDescriptorCells = 16;  // along each axis of the grid
inline constexpr int kDescriptorValues = kDescriptorCells * kDescriptorCells * kDescriptorCells;
// Side of the grid over the diameter of the object.
inline constexpr double kDescriptorSide = 1.3;

// Returns X_CF of a volume. Its x axis is the x axis of the camera, turned to be square to the ray.
// Returns nothing for a volume without matter.
std::optional<Pose> VolumeFrame(const CompletedVolume& volume);

// Appends the probabilities at the kDescriptorValues cells of a grid with side `side_m` (m) in F,
// turned by `angle_rad` about its z axis.
void AppendVolumeDescriptor(const CompletedVolume& volume, const Pose& X_CF, double angle_rad,
                            double side_m, std::vector<float>& values);

}  // namespace pickbed::perception
