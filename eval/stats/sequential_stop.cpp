#include "eval/stats/sequential_stop.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pickbed::eval {
namespace {

const SequentialOptions& Checked(const SequentialOptions& options) {
  CheckSettings("SequentialOptions", options);
  return options;
}

}  // namespace

void SequentialOptions::Visit(SettingsVisitor& v) {
  v.Real("confidence", confidence, {0.01, 0.999999}, "confidence of the interval");
  v.Integer("candidates", candidates, {2, 10000000}, "number of candidate means between 0 and 1");
  v.Real("largest_stake", largest_stake, {1e-6, 0.999999},
         "maximum share of the capital that can be lost in one scene");
}

SequentialStop::SequentialStop(double width, const SequentialOptions& options)
    : width_(width),
      options_(Checked(options)),
      log_above_(options.candidates + 1, 0.0),
      log_below_(options.candidates + 1, 0.0),
      high_(options.candidates) {
  if (!(width >= 0 && width <= 1)) throw std::logic_error("a width must be from 0 to 1");
}

void SequentialStop::Add(const Cluster& scene) {
  if (scene.samples > 0) Add(static_cast<double>(scene.hits) / scene.samples);
}

void SequentialStop::Add(double scene_mean) {
  const double x = std::clamp(scene_mean, 0.0, 1.0);
  // The stake depends only on earlier scenes.
  const double t = scenes_ + 1;
  const double variance = squares_ / t;
  const double threshold = std::log(2 / (1 - options_.confidence));
  const double stake = std::sqrt(2 * threshold / (variance * t * std::log(1 + t)));
  const int last = options_.candidates;
  // A rejected candidate stays rejected and needs no capital.
  for (int k = low_ + 1; k < high_; ++k) {
    const double m = static_cast<double>(k) / last;
    const double above = std::min(stake, options_.largest_stake / m);
    const double below = std::min(stake, options_.largest_stake / (1 - m));
    log_above_[k] += std::log1p(above * (x - m));
    log_below_[k] += std::log1p(-below * (x - m));
  }
  // Capital against smaller means decreases with m, and capital against larger means increases. So
  // the rejected candidates are at the two ends.
  while (low_ + 1 < high_ && log_above_[low_ + 1] >= threshold) ++low_;
  while (high_ - 1 > low_ && log_below_[high_ - 1] >= threshold) --high_;
  interval_ = {static_cast<double>(low_) / last, static_cast<double>(high_) / last};

  ++scenes_;
  sum_ += x;
  const double running_mean = (0.5 + sum_) / (scenes_ + 1);
  squares_ += (x - running_mean) * (x - running_mean);
}

}  // namespace pickbed::eval
