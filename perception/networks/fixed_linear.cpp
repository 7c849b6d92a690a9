#include "perception/networks/fixed_linear.h"

#include <torch/utils.h>

#include <algorithm>
#include <vector>

namespace pickbed::perception {
namespace {

constexpr int64_t kRows = 4, kColumns = 16;  // of the block whose sums stay in registers

int64_t RoundedUp(int64_t value, int64_t step) { return (value + step - 1) / step * step; }

// Eight columns. The compiler splits them into two registers where there are none of this size.
constexpr int64_t kLanes = 8;
typedef float Lanes __attribute__((vector_size(kLanes * sizeof(float)), aligned(4), may_alias));

// Adds the products of a block in the order of the inputs. Several columns are computed at once,
// which does not change the order within a column. The variant for AVX2 has no fused multiply-add,
// so that both variants round alike.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
__attribute__((target_clones("avx2", "default")))
#endif
void MultiplyBlock(const float* rows, const float* weights, int64_t inputs, float* sums) {
  static_assert(kRows == 4 && kColumns == 2 * kLanes);
  Lanes* const stored = reinterpret_cast<Lanes*>(sums);
  Lanes a0 = stored[0], a1 = stored[1], b0 = stored[2], b1 = stored[3];
  Lanes c0 = stored[4], c1 = stored[5], d0 = stored[6], d1 = stored[7];
  for (int64_t input = 0; input < inputs; ++input) {
    const Lanes* const columns = reinterpret_cast<const Lanes*>(weights + input * kColumns);
    const Lanes left = columns[0], right = columns[1];
    const float a = rows[input], b = rows[inputs + input];
    const float c = rows[2 * inputs + input], d = rows[3 * inputs + input];
    a0 += a * left;
    a1 += a * right;
    b0 += b * left;
    b1 += b * right;
    c0 += c * left;
    c1 += c * right;
    d0 += d * left;
    d1 += d * right;
  }
  stored[0] = a0, stored[1] = a1, stored[2] = b0, stored[3] = b1;
  stored[4] = c0, stored[5] = c1, stored[6] = d0, stored[7] = d1;
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
