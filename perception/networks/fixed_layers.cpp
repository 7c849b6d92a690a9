#include "perception/networks/fixed_layers.h"

#include <torch/nn/functional/normalization.h>
#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/networks/fixed_sums.h"

namespace pickbed::perception {
namespace {

// Returns the weights [outputs, inputs] as blocks of kSumColumns outputs, each [inputs,
// kSumColumns].
std::vector<float> PackedColumns(const at::Tensor& weight) {
  const int64_t outputs = weight.size(0), inputs = weight.size(1);
  const float* const weights = weight.data_ptr<float>();
  std::vector<float> packed(RoundedUp(outputs, kSumColumns) * inputs);
  for (int64_t output = 0; output < outputs; ++output) {
    float* const block = packed.data() + output / kSumColumns * kSumColumns * inputs;
    for (int64_t input = 0; input < inputs; ++input) {
      block[input * kSumColumns + output % kSumColumns] = weights[output * inputs + input];
    }
  }
  return packed;
}

// Applies `function` to each value.
template <typename Function>
at::Tensor Mapped(const at::Tensor& values, const Function& function) {
  at::Tensor result = values.contiguous().clone();
  float* const plain = result.data_ptr<float>();
  std::transform(plain, plain + result.numel(), plain, function);
  return result;
}

// Computes rows [count, inputs] to [count, outputs].
at::Tensor LinearRows(const at::Tensor& weight, const at::Tensor& bias, const at::Tensor& rows) {
  const int64_t count = rows.size(0), inputs = rows.size(1), outputs = weight.size(0);
  const std::vector<float> weights = PackedColumns(weight);
  std::vector<int64_t> offsets(inputs);
  for (int64_t input = 0; input < inputs; ++input) offsets[input] = input * kSumColumns;
  at::Tensor padded = torch::zeros({RoundedUp(count, kSumRows), inputs});
  padded.slice(0, 0, count).copy_(rows);
  at::Tensor result = torch::empty({count, outputs});
  float* const values = result.data_ptr<float>();
  for (int64_t first = 0; first < outputs; first += kSumColumns) {
    const int64_t width = std::min(kSumColumns, outputs - first);
    const float* const columns = weights.data() + first * inputs;
    for (int64_t row = 0; row < count; row += kSumRows) {
      float sums[kSumRows * kSumColumns] = {};
      for (int64_t i = 0; i < kSumRows; ++i) {
        std::copy_n(bias.data_ptr<float>() + first, width, sums + i * kSumColumns);
      }
      AddProducts({padded.data_ptr<float>() + row * inputs, columns, columns + kSumLanes,
                   offsets.data(), inputs},
                  sums);
      for (int64_t i = 0; i < std::min(kSumRows, count - row); ++i) {
        std::copy_n(sums + i * kSumColumns, width, values + (row + i) * outputs + first);
      }
    }
  }
  return result;
}

}  // namespace

bool ComputedByLibtorch(const at::Tensor& weight, const at::Tensor& input) {
  const bool records =
      torch::GradMode::is_enabled() && (weight.requires_grad() || input.requires_grad());
  return records || !input.device().is_cpu();
}

at::Tensor ApplyLinear(torch::nn::Linear& layer, const at::Tensor& rows) {
  if (ComputedByLibtorch(layer->weight, rows)) return layer(rows);
  std::vector<int64_t> sizes = rows.sizes().vec();
  sizes.back() = layer->weight.size(0);
  return LinearRows(layer->weight.contiguous(), layer->bias.contiguous(),
                    rows.reshape({-1, rows.size(-1)}))
      .view(sizes);
}

at::Tensor UnitRows(const at::Tensor& rows) {
  if (ComputedByLibtorch(rows, rows)) {
    return torch::nn::functional::normalize(rows,
                                            torch::nn::functional::NormalizeFuncOptions().dim(1));
  }
  constexpr float kMinNorm = 1e-12f;  // as libtorch
  at::Tensor result = rows.contiguous().clone();
  const int64_t width = rows.size(1);
  float* row = result.data_ptr<float>();
  for (int64_t i = 0; i < rows.size(0); ++i, row += width) {
    float squared = 0;
    for (int64_t k = 0; k < width; ++k) squared += row[k] * row[k];
    const float norm = std::max(std::sqrt(squared), kMinNorm);
    for (int64_t k = 0; k < width; ++k) row[k] /= norm;
  }
  return result;
}

at::Tensor ClassProbabilities(const at::Tensor& logits) {
  if (ComputedByLibtorch(logits, logits)) return torch::softmax(logits, 1);
  at::Tensor result = logits.contiguous().clone();
  const int64_t width = logits.size(1);
  float* row = result.data_ptr<float>();
  for (int64_t i = 0; i < logits.size(0); ++i, row += width) {
    const float largest = *std::max_element(row, row + width);
    float sum = 0;
    for (int64_t k = 0; k < width; ++k) sum += row[k] = std::exp(row[k] - largest);
    for (int64_t k = 0; k < width; ++k) row[k] /= sum;
  }
  return result;
}

at::Tensor ApplyLogistic(const at::Tensor& values) {
  if (ComputedByLibtorch(values, values)) return torch::sigmoid(values);
  return Mapped(values, [](float x) { return 1 / (1 + std::exp(-x)); });
}

at::Tensor ApplyExponential(const at::Tensor& values) {
  if (ComputedByLibtorch(values, values)) return torch::exp(values);
  return Mapped(values, [](float x) { return std::exp(x); });
}

}  // namespace pickbed::perception
