#include "perception/networks/fixed_convolution.h"

#include <torch/utils.h>

#include <algorithm>
#include <array>
#include <vector>

#include "perception/networks/fixed_layers.h"
#include "perception/networks/fixed_sums.h"

namespace pickbed::perception {
namespace {

using Sizes = std::array<int64_t, 3>;  // depth, height, width

struct Window {
  Sizes size, stride, padding;
};

// The padded channels of one sample, arranged such that kSumLanes neighboring outputs of a row read
// neighboring values for each weight: a row has first its columns 0, stride, 2 stride, ..., then
// its columns 1, stride + 1, ... Output rows are rounded up to a multiple of kSumLanes.
class PaddedSample {
 public:
  PaddedSample(int64_t channels, const Sizes& input, const Window& window)
      : channels_(channels), input_(input), window_(window) {
    for (int i = 0; i < 3; ++i) {
      output_[i] = (input[i] + 2 * window.padding[i] - window.size[i]) / window.stride[i] + 1;
    }
    const int64_t stride = window.stride[2];
    width_ = RoundedUp(output_[2], kSumLanes);
    phase_ = std::max(width_ + (window.size[2] - 1) / stride + 1,
                      (input[2] + window.padding[2] + stride - 1) / stride + 1);
    row_ = stride * phase_;
    plane_ = (input[1] + 2 * window.padding[1]) * row_;
    channel_ = (input[0] + 2 * window.padding[0]) * plane_;
    values_.resize(channels * channel_);
  }

  const Sizes& output() const { return output_; }
  int64_t width() const { return width_; }  // of an output row, rounded up
  const float* values() const { return values_.data(); }

  void Fill(const float* sample) {
    for (int64_t c = 0; c < channels_; ++c) {
      for (int64_t z = 0; z < input_[0]; ++z) {
        for (int64_t y = 0; y < input_[1]; ++y, sample += input_[2]) {
          FillRow(sample, values_.data() + c * channel_ + (z + window_.padding[0]) * plane_ +
                              (y + window_.padding[1]) * row_);
        }
      }
    }
  }

  // Returns the offset of each weight of an output, in the order of the weights.
  std::vector<int64_t> Offsets() const {
    std::vector<int64_t> offsets;
    for (int64_t c = 0; c < channels_; ++c) {
      for (int64_t z = 0; z < window_.size[0]; ++z) {
        for (int64_t y = 0; y < window_.size[1]; ++y) {
          for (int64_t x = 0; x < window_.size[2]; ++x) {
            offsets.push_back(c * channel_ + z * plane_ + y * row_ + Column(x));
          }
        }
      }
    }
    return offsets;
  }

  // Returns the place of the first weight's value for each group of kSumLanes outputs.
  std::vector<int64_t> Groups() const {
    std::vector<int64_t> groups;
    for (int64_t z = 0; z < output_[0]; ++z) {
      for (int64_t y = 0; y < output_[1]; ++y) {
        for (int64_t x = 0; x < width_; x += kSumLanes) {
          groups.push_back(z * window_.stride[0] * plane_ + y * window_.stride[1] * row_ + x);
        }
      }
    }
    return groups;
  }

 private:
  int64_t Column(int64_t x) const { return x % window_.stride[2] * phase_ + x / window_.stride[2]; }
  void FillRow(const float* from, float* row) const {
    if (window_.stride[2] == 1) {
      std::copy_n(from, input_[2], row + window_.padding[2]);
      return;
    }
    for (int64_t x = 0; x < input_[2]; ++x) row[Column(x + window_.padding[2])] = from[x];
  }

  int64_t channels_;
  Sizes input_, output_{};
  Window window_;
  int64_t width_, phase_, row_, plane_, channel_;
  std::vector<float> values_;
};

// Weights with rows of zeros up to a multiple of kSumRows, and the bias likewise.
struct PaddedWeights {
  PaddedWeights(const at::Tensor& weight, const at::Tensor& bias)
      : outputs(weight.size(0)), terms(weight.numel() / outputs) {
    rows.resize(RoundedUp(outputs, kSumRows) * terms);
    start.resize(RoundedUp(outputs, kSumRows));
    const at::Tensor plain = weight.contiguous();
    std::copy_n(plain.data_ptr<float>(), plain.numel(), rows.begin());
    if (!bias.defined()) return;
    std::copy_n(bias.contiguous().data_ptr<float>(), outputs, start.begin());
  }
  int64_t outputs, terms;
  std::vector<float> rows, start;
};

// Computes all channels of two groups of outputs. `left` and `right` are the places of the groups
// in `grouped`, whose channels have `area` values.
void ConvolveGroups(const PaddedWeights& weights, const float* values, const int64_t* offsets,
                    std::array<int64_t, 2> places, std::array<float*, 2> grouped, int64_t area) {
  for (int64_t first = 0; first < weights.outputs; first += kSumRows) {
    float sums[kSumRows * kSumColumns];
    for (int64_t i = 0; i < kSumRows; ++i) {
      std::fill_n(sums + i * kSumColumns, kSumColumns, weights.start[first + i]);
    }
    AddProducts({weights.rows.data() + first * weights.terms, values + places[0],
                 values + places[1], offsets, weights.terms},
                sums);
    for (int64_t i = 0; i < std::min(kSumRows, weights.outputs - first); ++i) {
      const float* const row = sums + i * kSumColumns;
      std::copy_n(row, kSumLanes, grouped[0] + (first + i) * area);
      std::copy_n(row + kSumLanes, kSumLanes, grouped[1] + (first + i) * area);
    }
  }
}

// Computes a convolution of [count, channels, depth, height, width].
at::Tensor Convolve(const at::Tensor& weight, const at::Tensor& bias, const at::Tensor& input,
                    const Window& window) {
  const int64_t count = input.size(0), channels = input.size(1);
  const PaddedWeights weights(weight, bias);
  PaddedSample sample(channels, {input.size(2), input.size(3), input.size(4)}, window);
  const std::vector<int64_t> offsets = sample.Offsets(), groups = sample.Groups();
  const int64_t rows = sample.output()[0] * sample.output()[1];
  const int64_t area = rows * sample.width();
  const auto last = static_cast<int64_t>(groups.size()) - 1;
  const at::Tensor values = input.contiguous();
  const int64_t sample_size = values.numel() / std::max<int64_t>(count, 1);
  at::Tensor result = torch::empty(
      {count, weights.outputs, sample.output()[0], sample.output()[1], sample.width()});
  for (int64_t n = 0; n < count; ++n) {
    sample.Fill(values.data_ptr<float>() + n * sample_size);
    float* const to = result.data_ptr<float>() + n * weights.outputs * area;
    for (int64_t group = 0; group <= last; group += 2) {
      const int64_t other = std::min(group + 1, last);
      ConvolveGroups(weights, sample.values(), offsets.data(), {groups[group], groups[other]},
                     {to + group * kSumLanes, to + other * kSumLanes}, area);
    }
  }
  return result.slice(4, 0, sample.output()[2]).contiguous();
}

// libtorch's takes several times as long for images that are stored channel by channel.
at::Tensor HalvedImages(const at::Tensor& images) {
  const int64_t planes = images.size(0) * images.size(1), width = images.size(3);
  const int64_t rows = images.size(2) / 2, columns = width / 2;
  const at::Tensor values = images.contiguous();
  at::Tensor result = torch::empty({images.size(0), images.size(1), rows, columns});
  float* to = result.data_ptr<float>();
  for (int64_t plane = 0; plane < planes; ++plane) {
    const float* row = values.data_ptr<float>() + plane * images.size(2) * width;
    for (int64_t y = 0; y < rows; ++y, row += 2 * width, to += columns) {
      const float* const next = row + width;
      for (int64_t x = 0; x < columns; ++x) {
        to[x] =
            std::max(std::max(row[2 * x], row[2 * x + 1]), std::max(next[2 * x], next[2 * x + 1]));
      }
    }
  }
  return result;
}

// Applies a batch normalization to [count, channels, ...].
template <typename Layer>
at::Tensor Normalized(Layer& layer, const at::Tensor& values) {
  if (layer->is_training() || ComputedByLibtorch(layer->weight, values)) return layer(values);
  const at::Tensor deviation = torch::sqrt(layer->running_var + layer->options.eps());
  const at::Tensor scale = layer->weight / deviation;
  const at::Tensor shift = layer->bias - layer->running_mean * scale;
  std::vector<int64_t> shape(values.dim() - 1, 1);
  shape.front() = -1;
  return (values * scale.view(shape)).add_(shift.view(shape));
}

}  // namespace

at::Tensor ApplyConvolution(torch::nn::Conv2d& layer, const at::Tensor& images) {
  if (ComputedByLibtorch(layer->weight, images)) return layer(images);
  const auto& options = layer->options;
  const at::Tensor& weight = layer->weight;
  const auto padding = c10::get<torch::ExpandingArray<2>>(options.padding());
  const Window window{{1, weight.size(2), weight.size(3)},
                      {1, options.stride()->at(0), options.stride()->at(1)},
                      {0, padding->at(0), padding->at(1)}};
  return Convolve(weight, layer->bias, images.unsqueeze(2), window).squeeze(2);
}

at::Tensor ApplyConvolution(torch::nn::Conv3d& layer, const at::Tensor& volumes) {
  if (ComputedByLibtorch(layer->weight, volumes)) return layer(volumes);
  const auto& options = layer->options;
  const at::Tensor& weight = layer->weight;
  const auto padding = c10::get<torch::ExpandingArray<3>>(options.padding());
  const Window window{
      {weight.size(2), weight.size(3), weight.size(4)}, *options.stride(), *padding};
  return Convolve(weight, layer->bias, volumes, window);
}

at::Tensor HalvedByMaximum(const at::Tensor& images) {
  if (ComputedByLibtorch(images, images)) return torch::max_pool2d(images, 2);
  return HalvedImages(images);
}

at::Tensor ApplyNormalization(torch::nn::BatchNorm2d& layer, const at::Tensor& images) {
  return Normalized(layer, images);
}

at::Tensor ApplyNormalization(torch::nn::BatchNorm3d& layer, const at::Tensor& volumes) {
  return Normalized(layer, volumes);
}

}  // namespace pickbed::perception
