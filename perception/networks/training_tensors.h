#pragma once

// A TrainingBatch (torch_network.h) as the networks see it.

#include <ATen/core/Tensor.h>

namespace pickbed {

// N = 2 count rows: count anchors, then their codes.
struct TrainingTensors {
  at::Tensor patches;        // N x 4 x 32 x 32
  at::Tensor pose_distance;  // count x count, of anchor i and code j, in diameters
  // Of networks that regress:
  at::Tensor parts;      // N, index of the part
  at::Tensor rotations;  // N x variants x 4, quaternions w x y z of all symmetric poses
  at::Tensor middles;    // N x 3, the part's centre of mass in the patch's frame, in patch sides
};

}  // namespace pickbed
