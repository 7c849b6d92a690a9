#pragma once

// A TrainingBatch (see descriptor_network.h) as tensors.

#include <ATen/core/Tensor.h>

#include "perception/layer.h"

namespace pickbed::perception {

// N = 2 count rows: the count anchors, then their codes.
struct TrainingTensors {
  at::Tensor patches;        // N x 4 x 32 x 32
  at::Tensor pose_distance;  // count x count, anchor i to code j, in diameters
  // Only for networks that regress poses:
  at::Tensor objects;    // N, object index
  at::Tensor rotations;  // N x variants x 4, quaternions w x y z of all symmetric poses
  at::Tensor centers;    // N x 3, center of mass of the object in the patch frame, in patch sides
};

}  // namespace pickbed::perception
