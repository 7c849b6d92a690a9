#pragma once

// First layers of all networks for local patches: conv 5x5/2 12 - conv 3x3 24 - pool - conv 3x3 32
// - pool - full 128. It is similar to the network of Wohlhart and Lepetit, CVPR 2015, but smaller.
// The methods share it, so they differ in their training and not in their capacity.

#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/types.h>

#include "perception/features/patch.h"

namespace pickbed::perception {

// Module with these layers.
class PatchTrunk : public torch::nn::Module {
 public:
  static constexpr int kFeatures = 128;

  PatchTrunk();
  // Maps count x 4 x 32 x 32 to count x kFeatures values >= 0.
  at::Tensor Forward(const at::Tensor& patches);
  double MultiplyAdds() const;  // number of operations for one patch

 private:
  torch::nn::Conv2d first_{nullptr}, second_{nullptr}, third_{nullptr};
  torch::nn::Linear hidden_{nullptr};
};

}  // namespace pickbed::perception
