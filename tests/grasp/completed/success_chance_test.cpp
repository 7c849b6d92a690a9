#include "grasp/completed/success_chance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

double LogOdds(double chance) { return std::log(chance / (1 - chance)); }

// A power of the score as the odds: doubling the score doubles them with the exponent 1.
TEST(SuccessChance, OddsOfTheObservedSurfaceAreAPowerOfTheScore) {
  const SuccessChance chance{.observed = 1.5, .observed_score = 1.2};
  const auto log_odds = [&](double score) {
    return LogOdds(chance.Of({GraspedSurface::kObserved, false, score}));
  };
  EXPECT_NEAR(log_odds(1), 1.5, 1e-9);
  EXPECT_NEAR(log_odds(0.6) - log_odds(0.3), 1.2 * std::log(2), 1e-9);
}

TEST(SuccessChance, ThinShapesAndHiddenFingersLoseChance) {
  const SuccessChance chance;
  const auto of = [&](double width_m, double hidden_m) {
    return chance.Of({GraspedSurface::kCompleted, false, 0.1, width_m, hidden_m});
  };
  EXPECT_NEAR(LogOdds(of(0.015, 0)), chance.completed, 1e-9);
  EXPECT_EQ(of(0.013, 0), of(0.019, 0)) << "neither thin nor wide";
  EXPECT_NEAR(LogOdds(of(0, 0)), chance.completed - chance.thin, 1e-9);
  EXPECT_GT(of(0.008, 0), of(0.004, 0));
  EXPECT_GT(of(0.015, 0.002), of(0.015, 0.004));
  EXPECT_NEAR(LogOdds(of(0.015, 1)), chance.completed - chance.hidden, 1e-9);
}

TEST(SuccessChance, CoveredAndOffCenterGraspsLoseChanceOnBothSurfaces) {
  const SuccessChance chance;
  for (const GraspedSurface surface : {GraspedSurface::kCompleted, GraspedSurface::kObserved}) {
    const auto log_odds = [&](double covered, double center_offset_m) {
      return LogOdds(chance.Of({surface, false, 0.5, 0.015, 0, covered, center_offset_m}));
    };
    const double best = log_odds(0, 0);
    EXPECT_NEAR(best - log_odds(0.2, 0), 0.2 * chance.covered, 1e-9);
    EXPECT_NEAR(best - log_odds(0, 0.03), 0.03 * chance.center_offset_per_m, 1e-9);
  }
}

// The losses were measured with jaws.
TEST(SuccessChance, OddsOfACupAreAPowerOfItsScoreOnBothSurfaces) {
  const SuccessChance chance{.suction = 1, .suction_score = 2};
  for (const GraspedSurface surface : {GraspedSurface::kCompleted, GraspedSurface::kObserved}) {
    EXPECT_NEAR(LogOdds(chance.Of({surface, true, 0.5, 0, 0.01, 0.5, 0.02})), 1 - 2 * std::log(2),
                1e-9);
  }
}

// A loss divides the odds, whatever they are.
TEST(SuccessChance, RehearsalsDivideTheOdds) {
  const SuccessChance chance{.rehearsal_hit = 4, .rehearsal_lost = 1};
  for (const double before : {0.2, 0.9}) {
    const auto gain = [&](double hit, double lost) {
      return LogOdds(chance.AfterRehearsal(before, hit, lost)) - LogOdds(before);
    };
    EXPECT_NEAR(gain(0, 0), 0, 1e-9);
    EXPECT_NEAR(gain(1, 0), -4, 1e-9);
    EXPECT_NEAR(gain(0.5, 0.5), -2.5, 1e-9);
  }
  for (const double certain : {0.0, 1.0}) {
    EXPECT_NEAR(chance.AfterRehearsal(certain, 0.5, 0.5), certain, 1e-4);
  }
}

// Whatever a planner gives, the result is a probability.
TEST(SuccessChance, IsFiniteForAScoreOfZero) {
  const double chance = SuccessChance().Of({GraspedSurface::kObserved, false, 0});
  EXPECT_GE(chance, 0);
  EXPECT_LT(chance, 0.05);
}

}  // namespace
}  // namespace pickbed::tests
