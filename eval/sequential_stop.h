#pragma once

// Stopping when an interval is narrow enough, by one that may be looked at after every scene: a
// confidence sequence holds the true mean at all times jointly with the chance `confidence`, so
// that neither looking nor stopping at a lucky moment makes it false.
//
// Method: the hedged capital process of Waudby-Smith and Ramdas ("Estimating means of bounded
// random variables by betting", JRSS B 2024, sec. 4.3). For each candidate mean m, two gamblers bet
// that the scenes lie above and below m, at predictable stakes (their eq. 26); a gambler whose
// capital reaches 2 / (1 - confidence) has refuted m (Ville's inequality).

#include <vector>

#include "eval/statistics.h"

namespace pickbed {

struct SequentialOptions {
  double confidence = 0.95;
  // Candidates between 0 and 1 that are watched; the interval's ends lie on them, outwards.
  int candidates = 2000;
  // Largest share of a gambler's capital that may be lost in one scene, as the paper's c.
  double largest_stake = 0.5;
};

class SequentialStop {
 public:
  // Stops when the interval is no wider than `width`, 0 = never. Throws std::logic_error for a
  // width outside 0..1.
  explicit SequentialStop(double width, const SequentialOptions& options = {});

  // What a scene gives, 0..1: its share of hits. The mean is over scenes, each counting as much as
  // another. In the order of the scenes, never of their finishing, which would favour easy ones.
  void Add(double scene_mean);
  // Nothing where nothing was tried.
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
  double squares_ = 0.25;  // of deviations from the running means, with the paper's prior
  std::vector<double> log_above_, log_below_;  // capitals by candidate
  int low_ = 0, high_ = 0;                     // candidates at the interval's ends
  Interval interval_;
};

}  // namespace pickbed
