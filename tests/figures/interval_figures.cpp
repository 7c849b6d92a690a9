// Measures how often nominal 95 % intervals contain the truth in simulated experiments, printed to
// stdout:
//   interval_figures rates EXPERIMENTS    ClusterInterval compared with the percentile
//                                         bootstrap
//   interval_figures few EXPERIMENTS      ClusterInterval of few bins: lowest coverage, mean
//                                         width; the reason for kMinBinsOfInterval
//   interval_figures pairs EXPERIMENTS    PairedInterval, and false alarms of the paired tests
//
// Each scene draws its rate from a beta distribution with the given correlation within a scene. The
// number of picks per scene is constant, 1 to 20, geometric up to 40, 1 to 3, or until two failures
// in a row.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "eval/stats/paired_tests.h"
#include "tests/support/simulated_scenes.h"

namespace pickbed::tests {
namespace {

struct NamedSize {
  const char* name;
  SceneSize size;
};

std::vector<NamedSize> Sizes() {
  return {{"10", ConstantSize(10)},
          {"1..20", UniformSize(1, 20)},
          {"geometric", GeometricSize(0.15, 40)},
          {"1..3", UniformSize(1, 3)},
          {"until_failures", UntilFailures()}};
}

constexpr double kLowest = 0.93, kHighest = 0.97;

// Returns the rate over many scenes. It differs from `rate`, because with picks until failures the
// good scenes have more picks.
double TrueRate(double rate, double correlation, const SceneSize& size) {
  Rng rng(1);
  return RateOf(DrawScenes(1000000, rate, correlation, size, rng));
}

Interval PercentileBootstrap(const std::vector<Cluster>& scenes, Rng& rng) {
  constexpr int kResamples = 200;
  std::vector<double> rates;
  for (int k = 0; k < kResamples; ++k) {
    std::vector<Cluster> drawn;
    for (size_t i = 0; i < scenes.size(); ++i) {
      drawn.push_back(scenes[rng.Index(static_cast<int>(scenes.size()))]);
    }
    rates.push_back(RateOf(drawn));
  }
  std::sort(rates.begin(), rates.end());
  return {rates[kResamples / 40], rates[kResamples - 1 - kResamples / 40]};
}

struct Tally {
  int held = 0, samples = 0;
  void Count(const Interval& interval, double truth) {
    held += interval.low <= truth && truth <= interval.high;
    ++samples;
  }
  double share() const { return samples > 0 ? static_cast<double>(held) / samples : 0; }
};

void MeasureRates(int experiments) {
  fmt::print("{:<16}{:>7}{:>13}{:>7}{:>9}{:>12}\n", "picks", "scenes", "correlation", "rate",
             "covered", "percentile");
  int outside = 0, all = 0;
  double min_coverage = 1, max_coverage = 0;
  for (const NamedSize& size : Sizes()) {
    for (const int scenes : {40, 60, 100}) {
      for (const double correlation : {0.0, 0.1, 0.3, 0.5}) {
        for (const double rate : {0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9}) {
          const bool is_informed = std::string(size.name) == "until_failures";
          const double truth = is_informed ? TrueRate(rate, correlation, size.size) : rate;
          if (truth > 0.9) continue;
          Rng rng(5), bootstrap_rng(6);
          Tally ours, percentile;
          for (int k = 0; k < experiments; ++k) {
            const auto drawn = DrawScenes(scenes, rate, correlation, size.size, rng);
            ours.Count(ClusterInterval(drawn), truth);
            if (k % 10 == 0) percentile.Count(PercentileBootstrap(drawn, bootstrap_rng), truth);
          }
          const bool is_outside = ours.share() < kLowest || ours.share() > kHighest;
          fmt::print("{:<16}{:>7}{:>13.1f}{:>7.2f}{:>9.4f}{:>12.3f}{}\n", size.name, scenes,
                     correlation, truth, ours.share(), percentile.share(),
                     is_outside ? "  outside" : "");
          outside += is_outside;
          ++all;
          min_coverage = std::min(min_coverage, ours.share());
          max_coverage = std::max(max_coverage, ours.share());
        }
      }
    }
  }
  fmt::print("{} of {} outside {} to {}; from {:.4f} to {:.4f}\n", outside, all, kLowest, kHighest,
             min_coverage, max_coverage);
}

// Few bins of 8 to 14 picks. Experiments with fewer bins than an interval needs are left out, so
// measure those with a smaller kMinBinsOfInterval.
void MeasureFew(int experiments) {
  fmt::print("{:>5}{:>17}{:>12}\n", "bins", "lowest coverage", "mean width");
  for (const int bins : {2, 3, 4, 5, 6, 8, 10, 15, 20}) {
    double lowest = 1, width = 0;
    int cases = 0;
    for (const double correlation : {0.0, 0.1, 0.3}) {
      for (const double rate : {0.5, 0.7, 0.9, 0.95, 0.98}) {
        Rng rng(5);
        Tally covered;
        for (int k = 0; k < experiments; ++k) {
          const Interval interval =
              ClusterInterval(DrawScenes(bins, rate, correlation, UniformSize(8, 14), rng));
          if (!interval.is_known()) continue;
          covered.Count(interval, rate);
          width += interval.high - interval.low;
          ++cases;
        }
        lowest = std::min(lowest, covered.share());
      }
    }
    if (cases == 0) continue;
    fmt::print("{:>5}{:>17.3f}{:>12.2f}\n", bins, lowest, width / cases);
  }
}

void MeasurePairs(int experiments) {
  constexpr int kFlips = 199;
  fmt::print("{:<12}{:>7}{:>13}{:>7}{:>6}{:>9}{:>13}{:>9}\n", "picks", "scenes", "correlation",
             "rate", "rise", "covered", "false alarms", "McNemar");
  for (const NamedSize& size :
       {NamedSize{"1", ConstantSize(1)}, Sizes()[0], Sizes()[1], Sizes()[2], Sizes()[3]}) {
    for (const int scenes : {20, 40, 100}) {
      for (const double correlation : {0.1, 0.5}) {
        for (const double rate : {0.1, 0.5, 0.8}) {
          for (const double rise : {0.0, 0.1}) {
            Rng rng(7);
            Tally covered, alarms, mcnemar;
            for (int k = 0; k < experiments; ++k) {
              const ScenePairs pairs =
                  DrawPairs(scenes, rate, correlation, rise, 0.5, size.size, rng);
              covered.Count(PairedInterval(pairs.before, pairs.after), rise);
              if (rise > 0) continue;
              const double p = PairedRateTest(pairs.before, pairs.after, kFlips);
              alarms.Count({0, 0.05}, p);
              if (std::string(size.name) != "1") continue;
              Discordance d;
              for (int i = 0; i < scenes; ++i) {
                d.before_only += pairs.before[i].hits > pairs.after[i].hits;
                d.after_only += pairs.after[i].hits > pairs.before[i].hits;
              }
              mcnemar.Count({0, 0.05}, McNemarExact(d));
            }
            fmt::print("{:<12}{:>7}{:>13.1f}{:>7.1f}{:>6.1f}{:>9.4f}{:>13.4f}{:>9.4f}\n", size.name,
                       scenes, correlation, rate, rise, covered.share(), alarms.share(),
                       mcnemar.share());
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "interval_figures rates|few|pairs EXPERIMENTS\n");
    return 1;
  }
  const int experiments = std::atoi(argv[2]);
  if (std::string(argv[1]) == "rates") {
    pickbed::tests::MeasureRates(experiments);
  } else if (std::string(argv[1]) == "few") {
    pickbed::tests::MeasureFew(experiments);
  } else {
    pickbed::tests::MeasurePairs(experiments);
  }
  return 0;
}
