#pragma once

// Small networks and batches for the tests of the kinds of completion networks.

#include "perception/completion/training_sample.h"
#include "tests/perception/completion/solid_views.h"

namespace pickbed::perception {

inline CompletionNetworkOptions SmallNetwork(const std::string& kind) {
  CompletionNetworkOptions options;
  options.kind = kind;
  options.width_16 = options.width_8 = options.width_4 = 4;
  options.bottleneck = 8;
  options.image_width = 4;
  options.hidden = 16;
  options.rounds = 6;
  return options;
}

// Four views of a sphere, with volumes.
inline CompletionBatch SphereBatch() {
  const auto solid = SphereSolid(0.05f);
  std::vector<CompletionSample> samples;
  std::vector<TurnedSample> turned;
  for (int seed = 0; seed < 4; ++seed) {
    Rng rng(seed);
    const RandomView drawn = DrawView(*solid, {}, {}, rng);
    samples.push_back(MakeSample(*solid, drawn, 256, rng, /*with_volume=*/true));
  }
  for (const CompletionSample& sample : samples) turned.push_back({&sample, 0});
  return BatchOf(turned);
}

// Mean probability of the points of a batch that are inside, or outside.
inline double MeanProbability(const CompletionNetwork& network, const CompletionBatch& batch,
                              bool inside) {
  const std::vector<float> probabilities = network.Probabilities(batch);
  double sum = 0, count = 0;
  for (size_t i = 0; i < probabilities.size(); ++i) {
    if ((batch.inside[i] > 0.5f) != inside) continue;
    sum += probabilities[i];
    ++count;
  }
  return sum / count;
}

}  // namespace pickbed::perception
