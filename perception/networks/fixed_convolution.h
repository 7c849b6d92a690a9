#pragma once

// Layers for images and volumes with the same result on every x86-64 CPU, see fixed_layers.h.
// Tensors have the shape [count, channels, height, width] or [count, channels, depth, height,
// width].

#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/types.h>

#include "perception/layer.h"

namespace pickbed::perception {

// Applies a convolution. Its padding is of zeros, and it has no dilation and no groups.
at::Tensor ApplyConvolution(torch::nn::Conv2d& layer, const at::Tensor& images);
at::Tensor ApplyConvolution(torch::nn::Conv3d& layer, const at::Tensor& volumes);

// Returns the maximum of each cell of 2 x 2 pixels. An odd last row or column is dropped.
at::Tensor HalvedByMaximum(const at::Tensor& images);

// Applies a batch normalization.
at::Tensor ApplyNormalization(torch::nn::BatchNorm2d& layer, const at::Tensor& images);
at::Tensor ApplyNormalization(torch::nn::BatchNorm3d& layer, const at::Tensor& volumes);

}  // namespace pickbed::perception
