#include "perception/networks/fixed_convolution.h"

#include <gtest/gtest.h>
#include <torch/types.h>
#include <torch/utils.h>

#include <cstring>

namespace pickbed::perception {
namespace {

bool SameBytes(const at::Tensor& a, const at::Tensor& b) {
  const at::Tensor x = a.contiguous(), y = b.contiguous();
  return x.sizes() == y.sizes() &&
         std::memcmp(x.data_ptr<float>(), y.data_ptr<float>(), x.numel() * sizeof(float)) == 0;
}

// Convolution as a loop over outputs. It sums in the order of the weights and rounds each step.
at::Tensor InOrder(const at::Tensor& image, const torch::nn::Conv2d& layer, int64_t stride,
                   int64_t padding) {
  const at::Tensor weight = layer->weight.detach();
  const at::Tensor padded =
      torch::constant_pad_nd(image, {padding, padding, padding, padding}, 0).contiguous();
  const int64_t channels = weight.size(1), size = weight.size(2);
  const int64_t rows = (padded.size(2) - size) / stride + 1;
  const int64_t columns = (padded.size(3) - size) / stride + 1;
  at::Tensor result = torch::empty({image.size(0), weight.size(0), rows, columns});
  const auto in = padded.accessor<float, 4>();
  const auto w = weight.accessor<float, 4>();
  auto out = result.accessor<float, 4>();
  for (int64_t n = 0; n < image.size(0); ++n) {
    for (int64_t o = 0; o < weight.size(0); ++o) {
      for (int64_t y = 0; y < rows; ++y) {
        for (int64_t x = 0; x < columns; ++x) {
          volatile float sum = layer->bias[o].item<float>();
          for (int64_t c = 0; c < channels; ++c) {
            for (int64_t i = 0; i < size; ++i) {
              for (int64_t j = 0; j < size; ++j) {
                volatile float product = w[o][c][i][j] * in[n][c][y * stride + i][x * stride + j];
                sum = sum + product;
              }
            }
          }
          out[n][o][y][x] = sum;
        }
      }
    }
  }
  return result;
}

struct Case {
  int64_t channels, outputs, size, stride, padding, height, width;
};

const Case kCases[] = {{4, 12, 5, 2, 2, 32, 32}, {3, 5, 3, 1, 1, 7, 9},   {1, 1, 1, 1, 0, 1, 1},
                       {2, 7, 5, 1, 0, 13, 30},  {1, 4, 3, 3, 1, 11, 17}, {2, 3, 2, 2, 0, 5, 6}};

TEST(ApplyConvolution, SumsInTheOrderOfTheWeights) {
  torch::manual_seed(5);
  for (const Case& c : kCases) {
    torch::nn::Conv2d layer(torch::nn::Conv2dOptions(c.channels, c.outputs, c.size)
                                .stride(c.stride)
                                .padding(c.padding));
    const at::Tensor images = torch::randn({2, c.channels, c.height, c.width});
    const torch::InferenceMode inference;
    const at::Tensor expected = InOrder(images, layer, c.stride, c.padding);
    EXPECT_TRUE(SameBytes(ApplyConvolution(layer, images), expected)) << c.size << " " << c.width;
    const at::Tensor by_pixel = images.contiguous(at::MemoryFormat::ChannelsLast);
    EXPECT_TRUE(SameBytes(ApplyConvolution(layer, by_pixel), expected)) << "another layout";
  }
}

TEST(ApplyConvolution, AgreesWithLibtorchForVolumes) {
  torch::manual_seed(6);
  for (const int64_t stride : {1, 2}) {
    for (const int64_t side : {4, 16, 9}) {
      torch::nn::Conv3d layer(
          torch::nn::Conv3dOptions(6, 10, 3).stride(stride).padding(1).bias(false));
      const at::Tensor volumes = torch::randn({3, 6, side, side + 1, side});
      const torch::InferenceMode inference;
      EXPECT_TRUE(torch::allclose(ApplyConvolution(layer, volumes), layer(volumes), 1e-4, 1e-5));
    }
  }
}

TEST(ApplyConvolution, KeepsGradients) {
  torch::nn::Conv2d layer(torch::nn::Conv2dOptions(2, 3, 3));
  EXPECT_TRUE(ApplyConvolution(layer, torch::randn({1, 2, 5, 5})).requires_grad());
}

TEST(ApplyConvolution, NoImageGivesNoResult) {
  torch::nn::Conv2d layer(torch::nn::Conv2dOptions(2, 3, 3).padding(1));
  const torch::InferenceMode inference;
  EXPECT_EQ(ApplyConvolution(layer, torch::zeros({0, 2, 8, 8})).sizes(),
            (at::IntArrayRef{0, 3, 8, 8}));
}

TEST(HalvedByMaximum, EqualsLibtorch) {
  torch::manual_seed(7);
  for (const int64_t side : {2, 5, 16}) {
    const at::Tensor images = torch::randn({3, 4, side, side + 1});
    const torch::InferenceMode inference;
    EXPECT_TRUE(SameBytes(HalvedByMaximum(images), torch::max_pool2d(images, 2))) << side;
  }
}

TEST(ApplyNormalization, AgreesWithLibtorch) {
  torch::manual_seed(8);
  torch::nn::BatchNorm3d layer(5);
  layer->train();
  const at::Tensor volumes = 3 * torch::randn({4, 5, 2, 3, 4}) + 1;
  layer(volumes);  // sets the statistics
  layer->eval();
  const torch::InferenceMode inference;
  EXPECT_TRUE(torch::allclose(ApplyNormalization(layer, volumes), layer(volumes), 1e-5, 1e-5));
}

}  // namespace
}  // namespace pickbed::perception
