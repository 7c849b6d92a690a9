#include "perception/networks/fixed_layers.h"

#include <gtest/gtest.h>
#include <torch/utils.h>

#include <cstring>
#include <vector>

namespace pickbed::tests {
namespace {

// Sums in the order of the inputs, rounded after each operation, as the header promises.
std::vector<float> InOrder(const at::Tensor& rows, const torch::nn::Linear& layer) {
  const at::Tensor weight = layer->weight.detach(), bias = layer->bias.detach();
  std::vector<float> values;
  for (int64_t row = 0; row < rows.size(0); ++row) {
    for (int64_t output = 0; output < weight.size(0); ++output) {
      volatile float sum = bias[output].item<float>();  // no wider or fused arithmetic
      for (int64_t input = 0; input < weight.size(1); ++input) {
        volatile float product =
            rows[row][input].item<float>() * weight[output][input].item<float>();
        sum = sum + product;
      }
      values.push_back(float{sum});
    }
  }
  return values;
}

TEST(ApplyLinear, SumsInTheOrderOfTheInputs) {
  torch::manual_seed(3);
  for (const auto& [count, inputs, outputs] :
       {std::tuple(1, 1, 1), std::tuple(5, 33, 17), std::tuple(4, 64, 16), std::tuple(3, 50, 31)}) {
    torch::nn::Linear layer(inputs, outputs);
    const at::Tensor rows = torch::randn({count, inputs});
    const torch::InferenceMode inference;
    const at::Tensor result = ApplyLinear(layer, rows);
    const std::vector<float> expected = InOrder(rows, layer);
    ASSERT_EQ(result.sizes(), (at::IntArrayRef{count, outputs}));
    EXPECT_EQ(std::memcmp(result.data_ptr<float>(), expected.data(), expected.size() * 4), 0)
        << count << " rows of " << inputs << " to " << outputs;
  }
}

TEST(ApplyLinear, KeepsTheOtherDimensions) {
  torch::manual_seed(5);
  torch::nn::Linear layer(6, 3);
  const at::Tensor values = torch::randn({2, 5, 6});
  const torch::InferenceMode inference;
  EXPECT_TRUE(torch::equal(ApplyLinear(layer, values),
                           ApplyLinear(layer, values.view({10, 6})).view({2, 5, 3})));
}

TEST(FixedLayers, RowsAndFunctionsAgreeWithLibtorch) {
  torch::manual_seed(6);
  const at::Tensor rows = 4 * torch::randn({7, 33});
  const torch::InferenceMode inference;
  EXPECT_TRUE(torch::allclose(UnitRows(rows).norm(2, 1), torch::ones({7}), 1e-6, 1e-6));
  EXPECT_TRUE(torch::allclose(UnitRows(rows) * rows.norm(2, 1, true), rows, 1e-5, 1e-6));
  EXPECT_TRUE(torch::equal(UnitRows(torch::zeros({2, 3})), torch::zeros({2, 3})));
  EXPECT_TRUE(torch::allclose(ClassProbabilities(rows), torch::softmax(rows, 1), 1e-5, 1e-7));
  EXPECT_TRUE(torch::allclose(ApplyLogistic(rows), torch::sigmoid(rows), 1e-5, 1e-7));
  EXPECT_TRUE(torch::allclose(ApplyExponential(rows), torch::exp(rows), 1e-5, 1e-7));
}

TEST(ApplyLinear, AgreesWithLibtorchAndKeepsItsGradients) {
  torch::manual_seed(4);
  torch::nn::Linear layer(120, 40);
  const at::Tensor rows = torch::randn({9, 120});
  const at::Tensor with_gradient = ApplyLinear(layer, rows);
  EXPECT_TRUE(with_gradient.requires_grad());
  const torch::InferenceMode inference;
  EXPECT_TRUE(torch::allclose(ApplyLinear(layer, rows), with_gradient, 1e-5, 1e-5));
}

}  // namespace
}  // namespace pickbed::tests
