#pragma once

// Simulated scenes with correlated picks: each scene draws its rate from a beta distribution, so
// that two picks of a scene have the correlation `correlation`, and its number of picks.

#include <cmath>
#include <functional>
#include <vector>

#include "eval/stats/statistics.h"
#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

inline double Gamma(double shape, Rng& rng) {  // Marsaglia and Tsang 2000
  if (shape < 1) {
    return Gamma(shape + 1, rng) * std::pow(1 - rng.Uniform(), 1 / shape);
  }
  const double d = shape - 1.0 / 3, c = 1 / std::sqrt(9 * d);
  while (true) {
    const double x = rng.Normal();
    const double v = std::pow(1 + c * x, 3);
    if (v <= 0) continue;
    if (std::log(1 - rng.Uniform()) < 0.5 * x * x + d - d * v + d * std::log(v)) return d * v;
  }
}

inline double SceneRate(double rate, double correlation, Rng& rng) {
  if (correlation <= 0) return rate;
  const double sum = (1 - correlation) / correlation;
  const double a = Gamma(rate * sum, rng), b = Gamma((1 - rate) * sum, rng);
  return a + b > 0 ? a / (a + b) : rng.Uniform() < rate;
}

// Draws the number of picks of a scene. kUntilFailures means: picks until two fail in a row or
// twelve succeed, so that good scenes have more picks.
using SceneSize = std::function<int(Rng&)>;
inline constexpr int kUntilFailures = 0;
inline SceneSize ConstantSize(int size) {
  return [size](Rng&) { return size; };
}
inline SceneSize UniformSize(int min_size, int max_size) {
  return [=](Rng& rng) { return min_size + rng.Index(max_size - min_size + 1); };
}
inline SceneSize GeometricSize(double stop, int max_size) {
  return [=](Rng& rng) {
    int size = 1;
    while (size < max_size && rng.Uniform() >= stop) ++size;
    return size;
  };
}
inline SceneSize UntilFailures() {
  return [](Rng&) { return kUntilFailures; };
}

inline Cluster DrawScene(double scene_rate, int size, Rng& rng) {
  Cluster scene;
  int failures_in_row = 0;
  while (size == kUntilFailures ? failures_in_row < 2 && scene.hits < 12 : scene.samples < size) {
    const bool hit = rng.Uniform() < scene_rate;
    ++scene.samples;
    scene.hits += hit;
    failures_in_row = hit ? 0 : failures_in_row + 1;
  }
  return scene;
}

inline std::vector<Cluster> DrawScenes(int count, double rate, double correlation,
                                       const SceneSize& size, Rng& rng) {
  std::vector<Cluster> scenes;
  for (int i = 0; i < count; ++i) {
    scenes.push_back(DrawScene(SceneRate(rate, correlation, rng), size(rng), rng));
  }
  return scenes;
}

// Results of two configurations on the same scenes. The second rate of a scene is the first rate,
// or a newly drawn rate with probability `own`, raised by `rise` on average.
struct ScenePairs {
  std::vector<Cluster> before, after;
};
inline ScenePairs DrawPairs(int count, double rate, double correlation, double rise, double own,
                            const SceneSize& size, Rng& rng) {
  ScenePairs pairs;
  for (int i = 0; i < count; ++i) {
    const double first = SceneRate(rate, correlation, rng);
    const double second = rng.Uniform() < own ? SceneRate(rate, correlation, rng) : first;
    const int samples = size(rng);
    pairs.before.push_back(DrawScene(first, samples, rng));
    // The mean rate rises by `rise` for any rate of the scene.
    const double share = rise >= 0 ? rise / (1 - rate) : rise / rate;
    const double moved = rise >= 0 ? second + share * (1 - second) : second + share * second;
    pairs.after.push_back(DrawScene(moved, samples, rng));
  }
  return pairs;
}

}  // namespace pickbed::tests
