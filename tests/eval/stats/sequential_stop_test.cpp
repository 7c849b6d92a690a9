#include "eval/stats/sequential_stop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/simulated_scenes.h"

namespace pickbed::tests {
namespace {

SequentialOptions Coarse() {
  SequentialOptions options;
  options.candidates = 200;  // for speed; the interval becomes wider
  return options;
}

// Checked after each scene, the sequence ever misses the mean in at most 5 % of the experiments.
// The usual interval, checked as often, misses it much more often.
TEST(SequentialStop, CoversTheMeanAtAllTimesJointly) {
  constexpr int kExperiments = 1000, kScenes = 300;
  for (const double rate : {0.1, 0.5, 0.9}) {
    Rng rng(31);
    int missed = 0, usual_missed = 0;
    for (int k = 0; k < kExperiments; ++k) {
      SequentialStop stop(0.1, Coarse());
      int hits = 0;
      bool miss = false, usual_miss = false;
      for (int i = 1; i <= kScenes; ++i) {
        const Cluster scene = DrawScene(rate, 1, rng);
        stop.Add(scene);
        hits += scene.hits;
        miss |= rate < stop.interval().low || rate > stop.interval().high;
        const Interval usual = WilsonInterval(hits, i);
        usual_miss |= rate < usual.low || rate > usual.high;
      }
      missed += miss;
      usual_missed += usual_miss;
    }
    EXPECT_LE(missed, (0.05 + 3 * std::sqrt(0.05 * 0.95 / kExperiments)) * kExperiments) << rate;
    EXPECT_GT(usual_missed, 0.15 * kExperiments) << rate;
  }
}

// The same holds for the interval at the moment of stopping, which a user reads.
TEST(SequentialStop, CoversTheMeanWhereItStops) {
  constexpr int kExperiments = 500;
  Rng rng(37);
  int missed = 0;
  double scenes = 0;
  for (int k = 0; k < kExperiments; ++k) {
    SequentialStop stop(0.1, Coarse());
    while (!stop.Reached() && stop.scenes() < 2000) {
      stop.Add(DrawScene(SceneRate(0.8, 0.2, rng), 10, rng));
    }
    EXPECT_TRUE(stop.Reached());
    missed += stop.interval().low > 0.8 || stop.interval().high < 0.8;
    scenes += stop.scenes();
  }
  EXPECT_LE(missed, 0.05 * kExperiments);
  // No interval needs fewer scenes than 4 * 1.96^2 * variance / width^2 = 69. One that may be
  // checked at any time needs a small multiple.
  EXPECT_GT(scenes / kExperiments, 69);
  EXPECT_LT(scenes / kExperiments, 4 * 69);
}

// Before the first scene nothing is known. Intervals only shrink and contain the mean.
TEST(SequentialStop, IntervalsOnlyShrink) {
  Rng rng(41);
  SequentialStop stop(0);
  Interval before = stop.interval();
  EXPECT_EQ(before.low, 0);
  EXPECT_EQ(before.high, 1);
  for (int i = 0; i < 500; ++i) {
    stop.Add(rng.Uniform(0.2, 0.6));
    EXPECT_GE(stop.interval().low, before.low);
    EXPECT_LE(stop.interval().high, before.high);
    before = stop.interval();
  }
  EXPECT_LT(before.low, 0.4);
  EXPECT_GT(before.high, 0.4);
  EXPECT_LT(before.high - before.low, 0.1);
  EXPECT_NEAR(stop.mean(), 0.4, 0.03);
  EXPECT_FALSE(stop.Reached()) << "a width of 0 never stops";
}

TEST(SequentialStop, AllSuccessesLeaveRoomBelow) {
  SequentialStop stop(0.2);
  for (int i = 0; i < 10; ++i) stop.Add(Cluster{5, 5});
  EXPECT_FALSE(stop.Reached()) << "ten scenes are not enough";
  for (int i = 0; i < 60; ++i) stop.Add(Cluster{5, 5});
  EXPECT_TRUE(stop.Reached());
  EXPECT_EQ(stop.interval().high, 1);
  EXPECT_LT(stop.interval().low, 1);
}

TEST(SequentialStop, ScenesWithoutSamplesAreIgnored) {
  SequentialStop stop(0.2);
  stop.Add(Cluster{0, 0});
  EXPECT_EQ(stop.scenes(), 0);
  EXPECT_THROW(SequentialStop(-0.1), std::logic_error);
  EXPECT_THROW(SequentialStop(1.5), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
