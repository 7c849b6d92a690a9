#pragma once

// Stopping rule: stop when the confidence interval of a mean is narrow enough. The interval may be
// checked after every scene. A confidence sequence contains the true mean at all times jointly with
// probability `confidence`, so neither the checks nor an early stop invalidate it.
//
// Method: hedged capital process of Waudby-Smith and Ramdas ("Estimating means of bounded random
// variables by betting", JRSS B 2024, sec. 4.3). For each candidate mean m, two bettors bet that
// the scenes are above or below m, with predictable stakes (eq. 26). A bettor whose capital reaches
// 2 / (1 - confidence) rejects m (Ville's inequality).

#include <vector>

#include "eval/stats/statistics.h"
#include "scenes/base/settings.h"

namespace pickbed::eval {

struct SequentialOptions {
  double confidence = 0.95;
  // Number of candidate means between 0 and 1; the interval ends are rounded outwards to them.
  int candidates = 2000;
  // Maximum share of the capital that can be lost in one scene (c in the paper).
  double largest_stake = 0.5;
  void Visit(SettingsVisitor& v);
};

// Confidence sequence of a mean with a stopping rule.
class SequentialStop {
 public:
  // Stops when the interval is at most `width` wide; 0 = never. Throws std::logic_error for a width
  // outside 0..1 and InputError for options out of range.
  explicit SequentialStop(double width, const SequentialOptions& options = {});

  // Adds the result of a scene, 0..1: its share of hits. All scenes have the same weight. Add
  // scenes in their fixed order. The order of completion would favor easy scenes.
  void Add(double scene_mean);
  // Adds the share of hits; does nothing if the scene has no samples.
  void Add(const Cluster& scene);

  Interval interval() const { return interval_; }
  int scenes() const { return scenes_; }
  double mean() const { return scenes_ > 0 ? sum_ / scenes_ : 0; }
  bool Reached() const { return width_ > 0 && interval_.high - interval_.low <= width_; }

 private:
  double width_;
  SequentialOptions options_;
  int scenes_ = 0;
  double sum_ = 0;
  double squares_ = 0.25;  // of deviations from the running means, with the prior of the paper
  std::vector<double> log_above_, log_below_;  // capitals by candidate
  int low_ = 0, high_ = 0;                     // candidates at the ends of the interval
  Interval interval_;
};

}  // namespace pickbed::eval
