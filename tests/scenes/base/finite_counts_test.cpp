#include "scenes/base/finite_counts.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace pickbed::scenes {
namespace {

TEST(FiniteCounts, AreTakenOnceAndOnlyIfNotZero) {
  TakeNotFiniteCounts();
  CountNotFinite(FiniteBoundary::kPoses, 2);
  CountNotFinite(FiniteBoundary::kGrasps);
  CountNotFinite(FiniteBoundary::kDepth, 0);
  EXPECT_EQ(TakeNotFiniteCounts(),
            (StageSeconds{{"not_finite/poses", 2}, {"not_finite/grasps", 1}}));
  EXPECT_TRUE(TakeNotFiniteCounts().empty());
}

TEST(FiniteCounts, AddUpOverThreads) {
  TakeNotFiniteCounts();
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      for (int k = 0; k < 1000; ++k) CountNotFinite(FiniteBoundary::kScores);
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(TakeNotFiniteCounts(), (StageSeconds{{"not_finite/scores", 4000}}));
}

TEST(FiniteCounts, DifferFromDurations) {
  EXPECT_TRUE(IsNotFiniteCount("not_finite/depth"));
  EXPECT_FALSE(IsNotFiniteCount("estimate/not_finite"));
}

TEST(FiniteCounts, WarningsNameTheBoundaryOnce) {
  TakeNotFiniteCounts();
  CountNotFinite(FiniteBoundary::kRefinedPoses, 3);
  EXPECT_EQ(NotFiniteWarnings(),
            std::vector<std::string>{"dropped values that are not finite: 3 of refined poses"});
  EXPECT_TRUE(NotFiniteWarnings().empty());
}

}  // namespace
}  // namespace pickbed::scenes
