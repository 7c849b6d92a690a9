#include "perception/completion_networks/implicit_decoder.h"

#include <algorithm>

#include "perception/completion_networks/network_options.h"
#include "perception/networks/fixed_sums.h"

namespace pickbed::perception {
namespace {

constexpr int64_t kQuad = 4;

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

typedef float Lanes __attribute__((vector_size(kSumLanes * sizeof(float)), aligned(4), may_alias));
typedef float Quad __attribute__((vector_size(kQuad * sizeof(float)), aligned(4), may_alias));

// Features of the places around a point, and the weights of these places.
struct WeightedPlaces {
  void Add(const FeatureGrid& grid, int64_t place, float weight) {
    features[count] = grid.values + place * grid.features;
    weights[count++] = weight;
  }
  int count = 0;
  const float* features[8];
  float weights[8];
};

// Writes the weighted sum of each of `size` features, in the order of the places.
// Several features are computed at once, which does not change the order within a sum. The variant
// for AVX2 has no fused multiply-add, so that both variants round alike.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__)
__attribute__((target_clones("avx2", "default")))
#endif
void SumPlaces(const WeightedPlaces& places, int64_t size, float* sums) {
  int64_t first = 0;
  for (; first + kSumLanes <= size; first += kSumLanes) {
    Lanes sum = {};
    for (int i = 0; i < places.count; ++i) {
      sum += *reinterpret_cast<const Lanes*>(places.features[i] + first) * places.weights[i];
    }
    *reinterpret_cast<Lanes*>(sums + first) = sum;
  }
  for (; first < size; ++first) {
    float sum = 0;
    for (int i = 0; i < places.count; ++i) sum += places.features[i][first] * places.weights[i];
    sums[first] = sum;
  }
}

void SampleVolume(const FeatureGrid& grid, const float* place, float* features) {
  const Neighbors xs(place[0], grid.width), ys(place[1], grid.height), zs(place[2], grid.depth);
  WeightedPlaces places;
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      const int64_t row = (zs.index[z] * grid.height + ys.index[y]) * grid.width;
      for (int x = 0; x < 2; ++x) {
        places.Add(grid, row + xs.index[x], xs.weight[x] * ys.weight[y] * zs.weight[z]);
      }
    }
  }
  SumPlaces(places, grid.features, features);
}

void SampleImage(const FeatureGrid& grid, const float* place, float* features) {
  const Neighbors xs(place[0], grid.width), ys(place[1], grid.height);
  WeightedPlaces places;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) {
      places.Add(grid, ys.index[y] * grid.width + xs.index[x], xs.weight[x] * ys.weight[y]);
    }
  }
  SumPlaces(places, grid.features, features);
}

// Turns the rows of four points, which begin `stride` values apart, into columns of a block with
// kSumColumns points.
void TransposeQuads(const float* rows, int64_t stride, float* columns) {
  const auto row = [&](int i) { return *reinterpret_cast<const Quad*>(rows + i * stride); };
  const Quad a = row(0), b = row(1), c = row(2), d = row(3);
  const Quad ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
  const Quad ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Quad cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
  const Quad cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const auto column = [&](int i) -> Quad& {
    return *reinterpret_cast<Quad*>(columns + i * kSumColumns);
  };
  column(0) = __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5);
  column(1) = __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7);
  column(2) = __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  column(3) = __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
}

// The compiler writes the values of std::fill_n one by one here.
void FillRow(float value, float* row) {
  const Quad values = {value, value, value, value};
  for (int64_t i = 0; i < kSumColumns; i += kQuad) *reinterpret_cast<Quad*>(row + i) = values;
}

}  // namespace

ImplicitDecoder::ImplicitDecoder(const FeatureGrid& volume, const FeatureGrid& image,
                                 const std::vector<DenseLayer>& layers)
    : volume_(volume), image_(image) {
  widest_ = RoundedUp(layers.front().inputs, kQuad);
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
  // Inputs of the first layer: a row for each of kSumColumns points.
  const int64_t stride = RoundedUp(layers_.front().inputs, kQuad);
  std::vector<float> rows(kSumColumns * stride);
  // Values of the same points, one row for each input of a layer.
  std::vector<float> values(widest_ * kSumColumns), next(widest_ * kSumColumns);
  for (int64_t first = 0; first < count; first += kSumColumns) {
    const int64_t points = std::min(kSumColumns, count - first);
    for (int64_t point = 0; point < points; ++point) {
      const float* const query = queries + (first + point) * kQueryValues;
      float* const row = rows.data() + point * stride;
      SampleVolume(volume_, query, row);
      SampleImage(image_, query + kImagePlace, row + volume_.features);
      std::copy_n(query, kQueryValues, row + volume_.features + image_.features);
    }
    for (int64_t point = 0; point < kSumColumns; point += kQuad) {
      for (int64_t input = 0; input < stride; input += kQuad) {
        TransposeQuads(rows.data() + point * stride + input, stride,
                       values.data() + input * kSumColumns + point);
      }
    }
    for (const Padded& layer : layers_) {
      const bool is_last = &layer == &layers_.back();
      for (int64_t row = 0; row < layer.rows; row += kSumRows) {
        float* const sums = next.data() + row * kSumColumns;
        for (int64_t i = 0; i < kSumRows; ++i) {
          FillRow(layer.bias[row + i], sums + i * kSumColumns);
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
