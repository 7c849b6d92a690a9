#include "sim/drop/fill_counts.h"

#include <gtest/gtest.h>

#include <numeric>

#include "scenes/base/error.h"
#include "sim/drop/fill_level.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

const Bin kFilledBin{{0.2, 0.15, 0.1}};

TEST(CountsForFill, ADropOfTheCountsReachesTheLevel) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  const std::vector<int> counts = CountsForFill(kFilledBin, objects, {1}, 0.5);
  Rng rng(7);  // not one of the seeds that the counts were measured with
  const DropResult drop = DropInstances(kFilledBin, objects, counts, rng);
  EXPECT_NEAR(MeasureFill(drop.scene, objects).fill_level, 0.5, 0.05);
  EXPECT_EQ(CountsForFill(kFilledBin, objects, {1}, 0.5), counts);  // now from the cache
}

TEST(CountsForFill, KeepsTheProportionsOfTheShares) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05), BoxObject({0.06, 0.02, 0.02}, 0.05)};
  const std::vector<int> counts = CountsForFill(kFilledBin, objects, {1, 3}, 0.4);
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_NEAR(counts[1], 3.0 * counts[0], 2.0);
}

TEST(CountsForFill, RefusesALevelThatOverflows) {
  // Each layer holds one plate, which covers half of the floor. A stack whose mean height is the
  // rim would be twice as high as the bin.
  const ObjectSet objects{BoxObject({0.12, 0.12, 0.03}, 0.2)};
  const std::string error = ErrorOf([&] { CountsForFill(kFilledBin, objects, {1}, 1.0); });
  EXPECT_NE(error.find("cannot be reached"), std::string::npos) << error;
}

TEST(CountsForFill, RefusesATable) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  const std::string error = ErrorOf([&] { CountsForFill(Bin{{0.2, 0.15, 0}}, objects, {1}, 0.5); });
  EXPECT_NE(error.find("table"), std::string::npos) << error;
}

}  // namespace
}  // namespace pickbed::tests
