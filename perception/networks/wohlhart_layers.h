#pragma once

// Layers and input tensor of the network of perception/networks/wohlhart.h. The network and its
// training share them.

#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/types.h>
#include <torch/utils.h>

#include "perception/networks/fixed_convolution.h"
#include "perception/networks/fixed_layers.h"
#include "perception/networks/torch_runtime.h"
#include "perception/networks/wohlhart.h"

namespace pickbed::perception {

// Number of input channels: 1 (depth), 3 (rgb) or 4 (rgbd).
int WohlhartChannels(const WohlhartOptions& options);

// Layers of section 3.2: conv 16 of 8x8 - pool - ReLU - conv 7 of 5x5 - pool - ReLU - full 256 -
// ReLU - full D. The descriptor is not normalised. RGB-D and D = 16 give 269,335 weights.
struct WohlhartLayers : torch::nn::Module {
  explicit WohlhartLayers(const WohlhartOptions& options) {
    using torch::nn::Conv2dOptions;
    first = register_module("first",
                            torch::nn::Conv2d(Conv2dOptions(WohlhartChannels(options), 16, 8)));
    second = register_module("second", torch::nn::Conv2d(Conv2dOptions(16, 7, 5)));
    const int side = ((kCropPixels - 7) / 2 - 4) / 2;
    hidden = register_module("hidden", torch::nn::Linear(7 * side * side, 256));
    last = register_module("last", torch::nn::Linear(256, options.descriptor));
  }
  at::Tensor Forward(const at::Tensor& crops) {
    at::Tensor x = torch::relu(HalvedByMaximum(ApplyConvolution(first, crops)));
    x = torch::relu(HalvedByMaximum(ApplyConvolution(second, x)));
    return ApplyLinear(last, torch::relu(ApplyLinear(hidden, x.flatten(1))));
  }
  torch::nn::Conv2d first{nullptr}, second{nullptr};
  torch::nn::Linear hidden{nullptr}, last{nullptr};
};

// Returns the `count` crops from `begin` as a tensor count x channels x 64 x 64. Depth is divided
// by depth_reach and clamped to [-1, 1]. Color is value / 255 - 0.5 as in the released code, and 0
// beyond the reach if the input has depth.
at::Tensor WohlhartTensor(const CropSet& crops, int64_t begin, int64_t count,
                          const WohlhartOptions& options, const torch::Device& device);

struct WohlhartNetwork::Impl {
  Impl(const WohlhartOptions& options, uint64_t seed) : options(options), device(NetworkDevice()) {
    at::set_num_threads(1);
    torch::manual_seed(seed);
    layers = std::make_shared<WohlhartLayers>(options);
    layers->to(device);
  }
  WohlhartOptions options;
  torch::Device device;
  std::shared_ptr<WohlhartLayers> layers;
};

}  // namespace pickbed::perception
