#include "perception/completion_networks/implicit_decoder.h"

#include <gtest/gtest.h>
#include <torch/nn/modules/linear.h>
#include <torch/utils.h>

#include <cmath>
#include <limits>

#include "perception/completion_networks/completion_net.h"
#include "perception/networks/fixed_layers.h"

namespace pickbed::perception {
namespace {

constexpr int64_t kCells = 4, kPixels = 6, kVolumeFeatures = 11, kImageFeatures = 3, kHidden = 7;

struct RandomDecoder {
  RandomDecoder() {
    torch::manual_seed(3);
    volume = torch::randn({1, kVolumeFeatures, kCells, kCells, kCells});
    image = torch::randn({1, kImageFeatures, 1, kPixels, kPixels});
    hidden = torch::nn::Linear(kVolumeFeatures + kImageFeatures + kQueryValues, kHidden);
    last = torch::nn::Linear(kHidden, 1);
    // No multiple of the points of a block. Some places are outside of volume and image.
    queries = torch::rand({1, 37, kQueryValues}) * 2.6 - 1.3;
  }
  ImplicitDecoder Plain() {
    volume_values = volume.permute({0, 2, 3, 4, 1}).contiguous();
    image_values = image.permute({0, 2, 3, 4, 1}).contiguous();
    const auto layer = [](const torch::nn::Linear& from) {
      return DenseLayer{from->weight.data_ptr<float>(), from->bias.data_ptr<float>(),
                        from->weight.size(1), from->weight.size(0)};
    };
    return ImplicitDecoder(
        {volume_values.data_ptr<float>(), kCells, kCells, kCells, kVolumeFeatures},
        {image_values.data_ptr<float>(), 1, kPixels, kPixels, kImageFeatures},
        {layer(hidden), layer(last)});
  }
  at::Tensor volume, image, queries, volume_values, image_values;
  torch::nn::Linear hidden{nullptr}, last{nullptr};
};

// The network learns with the sampling of libtorch, so the decoder must sample the same values.
TEST(ImplicitDecoder, HasTheBitsOfTheLayersAfterTheSamplingOfLibtorch) {
  const torch::NoGradGuard no_gradients;
  RandomDecoder random;
  const at::Tensor in_image = random.queries.slice(2, kImagePlace, kImagePlace + 2);
  const at::Tensor on_plane = torch::cat({in_image, torch::zeros({1, in_image.size(1), 1})}, 2);
  const at::Tensor known = torch::cat({SampledCode(random.volume, random.queries.slice(2, 0, 3)),
                                       SampledCode(random.image, on_plane), random.queries},
                                      2);
  const at::Tensor expected =
      ApplyLinear(random.last, torch::relu(ApplyLinear(random.hidden, known))).flatten();
  std::vector<float> logits(expected.numel());
  random.Plain().Decode(random.queries.data_ptr<float>(), expected.numel(), logits.data());
  for (int64_t i = 0; i < expected.numel(); ++i) {
    ASSERT_EQ(logits[i], expected.data_ptr<float>()[i]) << i;
  }
}

TEST(ImplicitDecoder, APlaceThatIsNoNumberStaysInTheGrid) {
  const torch::NoGradGuard no_gradients;
  RandomDecoder random;
  random.queries.slice(2, 0, kImagePlace + 2).fill_(std::numeric_limits<float>::quiet_NaN());
  std::vector<float> logits(1);
  random.Plain().Decode(random.queries.data_ptr<float>(), 1, logits.data());
  EXPECT_TRUE(std::isnan(logits[0]));
}

}  // namespace
}  // namespace pickbed::perception
