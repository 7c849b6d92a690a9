#include "perception/completion_networks/implicit_decoder.h"

#include <algorithm>

#include "perception/completion_networks/network_options.h"
#include "perception/networks/fixed_sums.h"

namespace pickbed::perception {
namespace {

// Values of the places of an axis on both sides of a point, and their weights.
struct Neighbors {
  // `place` is -1 at the beginning of the first of `size` places and 1 at the end of the last one.
  Neighbors(float place, int64_t size) {
    const float count = static_cast<float>(size);
    // The order of the arguments makes a place that is not a number the first one.
    const float at = std::min(count - 1, std::max(0.0f, ((place + 1) * count - 1) / 2));
    index[0] = static_cast<int64_t>(at);
    index[1] = std::min(index[0] + 1, size - 1);
    weight[0] = static_cast<float>(index[0] + 1) - at;
    weight[1] = at - static_cast<float>(index[0]);
  }
  int64_t index[2];
  float weight[2];
};

// Adds `weight` times the features at a place to `sums`.
void AddFeatures(const FeatureGrid& grid, int64_t place, float weight, float* sums) {
  const float* const values = grid.values + place * grid.features;
  for (int64_t i = 0; i < grid.features; ++i) sums[i] += values[i] * weight;
}

void SampleVolume(const FeatureGrid& grid, const float* place, float* features) {
  const Neighbors xs(place[0], grid.width), ys(place[1], grid.height), zs(place[2], grid.depth);
  std::fill_n(features, grid.features, 0.0f);
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      const int64_t row = (zs.index[z] * grid.height + ys.index[y]) * grid.width;
      for (int x = 0; x < 2; ++x) {
        AddFeatures(grid, row + xs.index[x], xs.weight[x] * ys.weight[y] * zs.weight[z], features);
      }
    }
  }
}

void SampleImage(const FeatureGrid& grid, const float* place, float* features) {
  const Neighbors xs(place[0], grid.width), ys(place[1], grid.height);
  std::fill_n(features, grid.features, 0.0f);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      AddFeatures(grid, ys.index[y] * grid.width + xs.index[x], xs.weight[x] * ys.weight[y],
                  features);
    }
  }
}

}  // namespace

ImplicitDecoder::ImplicitDecoder(const FeatureGrid& volume, const FeatureGrid& image,
                                 const std::vector<DenseLayer>& layers)
    : volume_(volume), image_(image) {
  widest_ = layers.front().inputs;
  for (const DenseLayer& layer : layers) {
    Padded& padded = layers_.emplace_back();
    padded.inputs = layer.inputs;
    padded.outputs = layer.outputs;
    padded.rows = RoundedUp(layer.outputs, kSumRows);
    padded.weights.resize(padded.rows * layer.inputs);
    padded.bias.resize(padded.rows);
    std::copy_n(layer.weights, layer.outputs * layer.inputs, padded.weights.begin());
    std::copy_n(layer.bias, layer.outputs, padded.bias.begin());
    widest_ = std::max(widest_, padded.rows);
  }
  for (int64_t row = 0; row < widest_; ++row) offsets_.push_back(row * kSumColumns);
}

void ImplicitDecoder::Decode(const float* queries, int64_t count, float* logits) const {
  // Values of kSumColumns points, one row for each input of a layer.
  std::vector<float> values(widest_ * kSumColumns), next(widest_ * kSumColumns);
  std::vector<float> features(std::max(volume_.features, image_.features));
  for (int64_t first = 0; first < count; first += kSumColumns) {
    const int64_t points = std::min(kSumColumns, count - first);
    for (int64_t point = 0; point < points; ++point) {
      const float* const query = queries + (first + point) * kQueryValues;
      float* to = values.data() + point;
      const auto append = [&](const float* from, int64_t size) {
        for (int64_t i = 0; i < size; ++i, to += kSumColumns) *to = from[i];
      };
      SampleVolume(volume_, query, features.data());
      append(features.data(), volume_.features);
      SampleImage(image_, query + kImagePlace, features.data());
      append(features.data(), image_.features);
      append(query, kQueryValues);
    }
    for (const Padded& layer : layers_) {
      const bool is_last = &layer == &layers_.back();
      for (int64_t row = 0; row < layer.rows; row += kSumRows) {
        float* const sums = next.data() + row * kSumColumns;
        for (int64_t i = 0; i < kSumRows; ++i) {
          std::fill_n(sums + i * kSumColumns, kSumColumns, layer.bias[row + i]);
        }
        AddProducts({layer.weights.data() + row * layer.inputs, values.data(),
                     values.data() + kSumLanes, offsets_.data(), layer.inputs},
                    sums);
        if (is_last) continue;
        for (int64_t i = 0; i < kSumRows * kSumColumns; ++i) sums[i] = std::max(sums[i], 0.0f);
      }
      std::swap(values, next);
    }
    std::copy_n(values.data(), points, logits + first);
  }
}

}  // namespace pickbed::perception
