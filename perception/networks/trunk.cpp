#include "perception/networks/trunk.h"

#include "perception/networks/fixed_convolution.h"
#include "perception/networks/fixed_layers.h"

namespace pickbed::perception {

PatchTrunk::PatchTrunk() {
  using torch::nn::Conv2dOptions;
  first_ = register_module(
      "first", torch::nn::Conv2d(Conv2dOptions(kPatchChannels, 12, 5).stride(2).padding(2)));
  second_ = register_module("second", torch::nn::Conv2d(Conv2dOptions(12, 24, 3).padding(1)));
  third_ = register_module("third", torch::nn::Conv2d(Conv2dOptions(24, 32, 3).padding(1)));
  const int area = (kPatchPixels / 8) * (kPatchPixels / 8);
  hidden_ = register_module("hidden", torch::nn::Linear(32 * area, kFeatures));
}

at::Tensor PatchTrunk::Forward(const at::Tensor& patches) {
  at::Tensor x = torch::relu(ApplyConvolution(first_, patches));
  x = torch::relu(HalvedByMaximum(ApplyConvolution(second_, x)));
  x = torch::relu(HalvedByMaximum(ApplyConvolution(third_, x)));
  return torch::relu(ApplyLinear(hidden_, x.flatten(1)));
}

double PatchTrunk::MultiplyAdds() const {
  constexpr double kHalf = kPatchPixels / 2, kQuarter = kPatchPixels / 4;  // sides, px
  return kHalf * kHalf * 12 * 25 * kPatchChannels + kHalf * kHalf * 24 * 9 * 12 +
         kQuarter * kQuarter * 32 * 9 * 24 + static_cast<double>(hidden_->weight.numel());
}

}  // namespace pickbed::perception
