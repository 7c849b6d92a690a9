#pragma once

// The decoder of the implicit network on the CPU, on plain arrays. It gives the same bits as the
// layers of fixed_layers.h after SampledCode() (completion_net.h), but is faster: a block of points
// passes all layers while its values are in the cache of the processor.

#include <cstdint>
#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

// Features at each place of a grid: depth x height x width x features.
struct FeatureGrid {
  const float* values;
  int64_t depth, height, width, features;
};

// A fully connected layer with weights outputs x inputs.
struct DenseLayer {
  const float* weights;
  const float* bias;
  int64_t inputs, outputs;
};

class ImplicitDecoder {
 public:
  // The first layer takes the features of the volume at a point, the features of the image at its
  // pixel, and the values of its query. All layers but the last one end with a ReLU. The last one
  // has one output. The arrays must outlive this object.
  ImplicitDecoder(const FeatureGrid& volume, const FeatureGrid& image,
                  const std::vector<DenseLayer>& layers);

  // Writes the logit of each query (count x kQueryValues) to `logits`.
  void Decode(const float* queries, int64_t count, float* logits) const;

 private:
  struct Padded {
    std::vector<float> weights, bias;  // rows up to a multiple of kSumRows
    int64_t inputs, outputs, rows;
  };

  FeatureGrid volume_, image_;
  std::vector<Padded> layers_;
  int64_t widest_ = 0;  // values of a point in a layer
  std::vector<int64_t> offsets_;
};

}  // namespace pickbed::perception
