#pragma once

// Two configurations on the same scenes: do they differ, by how much, and how many scenes would
// show it. All p values are two-sided; under the hypothesis of no difference p <= level comes no
// oftener than `level` (exactly so, whatever the number of scenes).

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "eval/statistics.h"

namespace pickbed {

// Scenes in which one of the two succeeded alone, where each scene gives one outcome.
struct Discordance {
  int before_only = 0, after_only = 0;
};

// McNemar's test (1947) in its exact form: before_only of all discordant scenes is binomial with
// 1/2. 1 where no scene is discordant.
double McNemarExact(const Discordance& scenes);

// after_only / before_only, the odds ratio of matched pairs, with the exact interval of Clopper and
// Pearson (1934) for the share; infinite where before_only is 0. Nothing without discordant scenes.
struct OddsRatio {
  double ratio = 1;
  Interval interval;
};
std::optional<OddsRatio> MatchedOddsRatio(const Discordance& scenes, double confidence = 0.95);

// Chance to change the labels `before` and `after` within scenes at random (each scene for itself)
// and find as large a difference as was found or a larger one. `statistic` gets, by scene, whether
// its labels are changed, and returns the size of the difference, larger for more. All 2^scenes
// changes where there are no more than `flips` of them, else `flips` random ones of which what was
// found is one more (Phipson and Smyth 2010), so that p is never 0.
using FlipStatistic = std::function<double(const std::vector<bool>& flipped)>;
double SignFlipTest(int scenes, const FlipStatistic& statistic, int flips = 10000,
                    uint64_t seed = 0);

// Whether rates differ, by sign flips of the difference over its standard error, which keeps the
// level also where the two differ in spread (Janssen 1999; Konietschke and Pauly 2014). Throws
// std::logic_error when the numbers of scenes differ.
double PairedRateTest(std::span<const Cluster> before, std::span<const Cluster> after,
                      int flips = 10000, uint64_t seed = 0);

// Whether medians of all values differ, by sign flips of their difference.
double PairedMedianTest(const ValueClusters& before, const ValueClusters& after, int flips = 2000,
                        uint64_t seed = 0);

// Interval of the median after less the median before: percentiles over `resamples` draws of as
// many scenes with replacement (Davison and Hinkley 1997, sec. 3.8). [-inf, inf] where either has
// no values.
Interval PairedMedianInterval(const ValueClusters& before, const ValueClusters& after,
                              double confidence = 0.95, int resamples = 2000, uint64_t seed = 0);

// What a trial is planned for: to find a difference that is there with this chance.
struct WantedPower {
  double power = 0.8;
  double level = 0.05;
};

// Scenes needed to show a difference when the differences of single scenes have this standard
// deviation: (z_level + z_power)^2 (deviation / difference)^2 and z_level^2 / 2 for Student's t
// (Guenther 1981). Nothing when the difference is 0 or more than 10 million scenes are needed.
std::optional<int> ScenesNeeded(double difference, double deviation,
                                const WantedPower& wanted = {});

// The same for McNemar's exact test, from the share of discordant scenes: Connor (1987) with the
// correction 1 / difference for its steps.
std::optional<int> ScenesNeededForMcNemar(double difference, double discordant,
                                          const WantedPower& wanted = {});

// Standard deviation of what single scenes add to the rise of a rate, sqrt(scenes) times its
// standard error; the scenes' own number is taken out.
double DeviationOfRise(std::span<const Cluster> before, std::span<const Cluster> after);

}  // namespace pickbed
