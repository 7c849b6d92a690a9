#pragma once

// conv 5x5/2 12 - conv 3x3 24 - pool - conv 3x3 32 - pool - full 128: the layers that the networks
// of local patches begin with. A smaller relative of the network of Wohlhart and Lepetit, CVPR
// 2015, so that methods differ in what they are taught, not in how much they can see.

#include <torch/nn.h>

#include "perception/patch.h"

namespace pickbed {

class PatchTrunk : public torch::nn::Module {
 public:
  static constexpr int kFeatures = 128;

  PatchTrunk();
  // count x 4 x 32 x 32 -> count x kFeatures, at least 0.
  at::Tensor Forward(const at::Tensor& patches);
  double MultiplyAdds() const;  // to look at one patch

 private:
  torch::nn::Conv2d first_{nullptr}, second_{nullptr}, third_{nullptr};
  torch::nn::Linear hidden_{nullptr};
};

// Rows of unit length.
at::Tensor UnitRows(const at::Tensor& rows);

}  // namespace pickbed
