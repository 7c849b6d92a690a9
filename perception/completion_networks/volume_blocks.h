#pragma once

// Layers that the kinds of completion networks share.

#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/types.h>

#include <cstdint>

#include "perception/networks/fixed_convolution.h"

namespace pickbed::perception {

// Convolution in three dimensions, batch normalization, ReLU.
struct VolumeBlock : torch::nn::Module {
  VolumeBlock(int64_t in, int64_t out, int64_t kernel, int64_t stride) {
    convolution =
        register_module("convolution", torch::nn::Conv3d(torch::nn::Conv3dOptions(in, out, kernel)
                                                             .stride(stride)
                                                             .padding(kernel / 2)
                                                             .bias(false)));
    norm = register_module("norm", torch::nn::BatchNorm3d(out));
  }
  at::Tensor forward(const at::Tensor& x) {
    return torch::relu(ApplyNormalization(norm, ApplyConvolution(convolution, x)));
  }
  torch::nn::Conv3d convolution{nullptr};
  torch::nn::BatchNorm3d norm{nullptr};
};

// Repeats each cell twice along the last three axes.
inline at::Tensor DoubledSize(const at::Tensor& x) {
  return at::upsample_nearest3d(x, {2 * x.size(2), 2 * x.size(3), 2 * x.size(4)});
}

}  // namespace pickbed::perception
