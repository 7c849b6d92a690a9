// conv 5x5/2 12 - conv 3x3 24 - pool - conv 3x3 32 - pool - full 128 - full D, unit length: 1.5 M
// multiply-adds a patch. A smaller relative of the network of Wohlhart and Lepetit, CVPR 2015.

#include <torch/nn.h>

#include "perception/networks/patch_network.h"
#include "perception/patch.h"

namespace pickbed {
namespace {

class ConvolutionalNetwork : public PatchNetwork, public torch::nn::Module {
 public:
  explicit ConvolutionalNetwork(int length) {
    using torch::nn::Conv2dOptions;
    first_ = register_module(
        "first", torch::nn::Conv2d(Conv2dOptions(kPatchChannels, 12, 5).stride(2).padding(2)));
    second_ = register_module("second", torch::nn::Conv2d(Conv2dOptions(12, 24, 3).padding(1)));
    third_ = register_module("third", torch::nn::Conv2d(Conv2dOptions(24, 32, 3).padding(1)));
    const int area = (kPatchPixels / 8) * (kPatchPixels / 8);
    hidden_ = register_module("hidden", torch::nn::Linear(32 * area, 128));
    last_ = register_module("last", torch::nn::Linear(128, length));
  }

  at::Tensor Forward(const at::Tensor& patches) override {
    at::Tensor x = torch::relu(first_(patches));
    x = torch::max_pool2d(torch::relu(second_(x)), 2);
    x = torch::max_pool2d(torch::relu(third_(x)), 2);
    x = last_(torch::relu(hidden_(x.flatten(1))));
    return torch::nn::functional::normalize(x,
                                            torch::nn::functional::NormalizeFuncOptions().dim(1));
  }

  torch::nn::Module& module() override { return *this; }

  double MultiplyAdds() const override {
    constexpr double kHalf = kPatchPixels / 2, kQuarter = kPatchPixels / 4;  // sides, px
    return kHalf * kHalf * 12 * 25 * kPatchChannels + kHalf * kHalf * 24 * 9 * 12 +
           kQuarter * kQuarter * 32 * 9 * 24 + static_cast<double>(hidden_->weight.numel()) +
           static_cast<double>(last_->weight.numel());
  }

 private:
  torch::nn::Conv2d first_{nullptr}, second_{nullptr}, third_{nullptr};
  torch::nn::Linear hidden_{nullptr}, last_{nullptr};
};

}  // namespace

std::unique_ptr<PatchNetwork> MakeConvolutionalNetwork(int descriptor_length) {
  return std::make_unique<ConvolutionalNetwork>(descriptor_length);
}

}  // namespace pickbed
