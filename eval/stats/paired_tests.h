#pragma once

// Comparison of two configurations on the same scenes: whether they differ, by how much, and how
// many scenes would show it. All p values are two-sided. If there is no difference, p <= level
// has at most the probability `level`. This holds exactly, for any number of scenes.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "eval/stats/statistics.h"

namespace pickbed::eval {

// Number of scenes in which only one of the two succeeded; each scene has one outcome.
struct Discordance {
  int before_only = 0, after_only = 0;
};

// Exact form of McNemar's test (1947): before_only is binomial with 1/2 among the discordant
// scenes. Returns the p value; 1 without discordant scenes.
double McNemarExact(const Discordance& scenes);

// Odds ratio of matched pairs: after_only / before_only, infinite if before_only is 0.
struct OddsRatio {
  double ratio = 1;
  Interval interval;
};
// Returns the odds ratio with the exact interval of Clopper and Pearson (1934) for the share of
// after_only; nullopt without discordant scenes.
std::optional<OddsRatio> MatchedOddsRatio(const Discordance& scenes, double confidence = 0.95);

// Sign-flip test: probability of a difference at least as large as observed if the labels `before`
// and `after` are exchanged at random in each scene. `statistic` receives one flag per scene
// (labels exchanged) and returns the size of the difference. All 2^scenes exchanges are used if
// they are at most `flips`. Otherwise `flips` random ones are used, and the observed one is added
// (Phipson and Smyth 2010), so that p is never 0.
using FlipStatistic = std::function<double(const std::vector<bool>& flipped)>;
// Returns the p value. Equal seeds give equal values.
double SignFlipTest(int scenes, const FlipStatistic& statistic, int flips = 10000,
                    uint64_t seed = 0);

// Tests whether two rates differ, with sign flips of the difference divided by its standard error.
// This keeps the level also if the two have different spread (Janssen 1999; Konietschke and Pauly
// 2014). Returns the p value. Throws std::logic_error if the numbers of scenes differ.
double PairedRateTest(std::span<const Cluster> before, std::span<const Cluster> after,
                      int flips = 10000, uint64_t seed = 0);

// Tests whether the medians of all values differ, with sign flips of their difference. Uses fewer
// flips, at least 200, for more than 50,000 values. Returns the p value.
double PairedMedianTest(const ValueClusters& before, const ValueClusters& after, int flips = 2000,
                        uint64_t seed = 0);

// Interval of the median after minus the median before: percentiles over `resamples` draws of
// scenes with replacement (Davison and Hinkley 1997, sec. 3.8), with fewer draws as above.
// [-inf, inf] if either has no values.
Interval PairedMedianInterval(const ValueClusters& before, const ValueClusters& after,
                              double confidence = 0.95, int resamples = 2000, uint64_t seed = 0);

// Power and level for which a number of scenes is planned.
struct WantedPower {
  double power = 0.8;
  double level = 0.05;
};

// Number of scenes to show a difference if single scenes differ with this standard deviation:
// (z_level + z_power)^2 (deviation / difference)^2, plus z_level^2 / 2 for Student's t (Guenther
// 1981). nullopt if the difference is 0 or more than 10 million scenes are needed.
std::optional<int> ScenesNeeded(double difference, double deviation,
                                const WantedPower& wanted = {});

// Like ScenesNeeded, for McNemar's exact test. `discordant` is the share of discordant scenes.
// Connor (1987), with the correction 1 / difference for the discrete steps.
std::optional<int> ScenesNeededForMcNemar(double difference, double discordant,
                                          const WantedPower& wanted = {});

// Standard deviation of the contribution of a single scene to the difference of two rates:
// sqrt(scenes) times the standard error. It does not depend on the number of scenes.
double DeviationOfRise(std::span<const Cluster> before, std::span<const Cluster> after);

}  // namespace pickbed::eval
