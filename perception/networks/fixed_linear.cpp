#include "perception/networks/fixed_linear.h"

#include <torch/utils.h>

#include <algorithm>
#include <vector>

namespace pickbed::perception {
namespace {

constexpr int64_t kRows = 4, kColumns = 16;  // of the block whose sums stay in registers

int64_t RoundedUp(int64_t value, int64_t step) { return (value + step - 1) / step * step; }

// Adds the products of a block in the order of the inputs. The compiler computes several columns at
// once, which does not change the order within a column. The variant for AVX2 has no fused
// multiply-add, so that both variants round alike.
#if defined(__GNUC__) && !defined(__clang__)
__attribute__((target_clones("avx2", "default")))
#endif
void MultiplyBlock(const float* rows, const float* weights, int64_t inputs, float* sums) {
  float block[kRows][kColumns];
  std::copy_n(sums, kRows * kColumns, &block[0][0]);
  for (int64_t input = 0; input < inputs; ++input) {
    for (int64_t row = 0; row < kRows; ++row) {
      const float value = rows[row * inputs + input];
      for (int64_t column = 0; column < kColumns; ++column) {
        block[row][column] += value * weights[input * kColumns + column];
      }
    }
  }
  std::copy_n(&block[0][0], kRows * kColumns, sums);
}

// Returns the weights [outputs, inputs] as blocks of kColumns outputs, each [inputs, kColumns].
std::vector<float> Packed(const float* weights, int64_t outputs, int64_t inputs) {
  std::vector<float> packed(RoundedUp(outputs, kColumns) * inputs);
  for (int64_t output = 0; output < outputs; ++output) {
    float* const block = packed.data() + output / kColumns * kColumns * inputs;
    for (int64_t input = 0; input < inputs; ++input) {
      block[input * kColumns + output % kColumns] = weights[output * inputs + input];
    }
  }
  return packed;
}

}  // namespace

at::Tensor ApplyLinear(torch::nn::Linear& layer, const at::Tensor& rows) {
  const bool records = torch::GradMode::is_enabled() && layer->weight.requires_grad();
  if (records || !rows.device().is_cpu() || rows.dim() != 2) return layer(rows);
  const int64_t count = rows.size(0), inputs = rows.size(1), outputs = layer->weight.size(0);
  const at::Tensor weight = layer->weight.contiguous(), bias = layer->bias.contiguous();
  const std::vector<float> weights = Packed(weight.data_ptr<float>(), outputs, inputs);
  at::Tensor padded = torch::zeros({RoundedUp(count, kRows), inputs});
  padded.slice(0, 0, count).copy_(rows);
  at::Tensor result = torch::empty({count, outputs});
  float* const values = result.data_ptr<float>();
  for (int64_t first = 0; first < outputs; first += kColumns) {
    const int64_t width = std::min(kColumns, outputs - first);
    for (int64_t row = 0; row < count; row += kRows) {
      float sums[kRows * kColumns] = {};
      for (int64_t i = 0; i < kRows; ++i) {
        std::copy_n(bias.data_ptr<float>() + first, width, sums + i * kColumns);
      }
      MultiplyBlock(padded.data_ptr<float>() + row * inputs, weights.data() + first * inputs,
                    inputs, sums);
      for (int64_t i = 0; i < std::min(kRows, count - row); ++i) {
        std::copy_n(sums + i * kColumns, width, values + (row + i) * outputs + first);
      }
    }
  }
  return result;
}

}  // namespace pickbed::perception
