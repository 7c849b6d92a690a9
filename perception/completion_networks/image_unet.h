#pragma once

// A 2D U-Net over the image of a view: features of each pixel.

#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>
#include <torch/types.h>

#include <cstdint>
#include <memory>

#include "perception/networks/fixed_convolution.h"

namespace pickbed::perception {

// Convolution of 3 x 3 pixels in two dimensions, batch normalization, ReLU.
struct ImageBlock : torch::nn::Module {
  ImageBlock(int64_t in, int64_t out, int64_t stride) {
    convolution = register_module(
        "convolution",
        torch::nn::Conv2d(
            torch::nn::Conv2dOptions(in, out, 3).stride(stride).padding(1).bias(false)));
    norm = register_module("norm", torch::nn::BatchNorm2d(out));
  }
  at::Tensor forward(const at::Tensor& x) {
    return torch::relu(ApplyNormalization(norm, ApplyConvolution(convolution, x)));
  }
  torch::nn::Conv2d convolution{nullptr};
  torch::nn::BatchNorm2d norm{nullptr};
};

// Levels of 64^2, 32^2, 16^2 and 8^2 pixels with 1, 2, 4 and 4 times `width` channels.
struct ImageUnet : torch::nn::Module {
  ImageUnet(int64_t in, int64_t width) {
    const auto add = [&](const char* name, int64_t from, int64_t to, int64_t stride) {
      return register_module(name, std::make_shared<ImageBlock>(from, to, stride));
    };
    first = add("first", in, width, 1);
    second = add("second", width, width, 1);
    down_32 = add("down_32", width, 2 * width, 2);
    at_32 = add("at_32", 2 * width, 2 * width, 1);
    down_16 = add("down_16", 2 * width, 4 * width, 2);
    at_16 = add("at_16", 4 * width, 4 * width, 1);
    down_8 = add("down_8", 4 * width, 4 * width, 2);
    at_8 = add("at_8", 4 * width, 4 * width, 1);
    up_16 = add("up_16", 8 * width, 4 * width, 1);
    up_32 = add("up_32", 6 * width, 2 * width, 1);
    up_64 = add("up_64", 3 * width, width, 1);
  }

  // Returns n x width x 64^2 features of n x in x 64^2 values.
  at::Tensor forward(const at::Tensor& images) {
    const auto doubled = [](const at::Tensor& x) {
      return at::upsample_nearest2d(x, {2 * x.size(2), 2 * x.size(3)});
    };
    const at::Tensor x_64 = second->forward(first->forward(images));
    const at::Tensor x_32 = at_32->forward(down_32->forward(x_64));
    const at::Tensor x_16 = at_16->forward(down_16->forward(x_32));
    const at::Tensor x_8 = at_8->forward(down_8->forward(x_16));
    const at::Tensor y_16 = up_16->forward(torch::cat({doubled(x_8), x_16}, 1));
    const at::Tensor y_32 = up_32->forward(torch::cat({doubled(y_16), x_32}, 1));
    return up_64->forward(torch::cat({doubled(y_32), x_64}, 1));
  }

  std::shared_ptr<ImageBlock> first, second, down_32, at_32, down_16, at_16, down_8, at_8;
  std::shared_ptr<ImageBlock> up_16, up_32, up_64;
};

}  // namespace pickbed::perception
