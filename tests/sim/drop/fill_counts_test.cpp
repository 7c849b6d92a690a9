#include "sim/drop/fill_counts.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "scenes/base/cache_file.h"
#include "sim/drop/fill_level.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

const Bin kFilledBin{{0.2, 0.15, 0.1}};

// Each test begins with an empty cache of its own.
class FillCounts : public testing::Test {
 protected:
  FillCounts() { setenv("XDG_CACHE_HOME", folder_.path().c_str(), 1); }
  ~FillCounts() override { unsetenv("XDG_CACHE_HOME"); }

  std::vector<std::filesystem::path> Files() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry :
         std::filesystem::directory_iterator(folder_.path() / "pickbed" / "fill")) {
      if (entry.path().extension() == ".txt") files.push_back(entry.path());
    }
    return files;
  }

  const TemporaryFolder folder_;
};

TEST_F(FillCounts, ADropOfTheCountsReachesTheLevel) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  const std::vector<int> counts = CountsForFill(kFilledBin, objects, {1}, 0.5);
  Rng rng(7);  // not one of the seeds that the counts were measured with
  const DropResult drop = DropInstances(kFilledBin, objects, counts, rng);
  EXPECT_NEAR(MeasureFill(drop.scene, objects).fill_level, 0.5, 0.05);
}

TEST_F(FillCounts, CountsAreReadFromTheCache) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  const std::vector<int> counts = CountsForFill(kFilledBin, objects, {1}, 0.2);
  ASSERT_EQ(Files().size(), 1u);
  WriteCacheFile(Files()[0], "7");
  EXPECT_EQ(CountsForFill(kFilledBin, objects, {1}, 0.2), std::vector<int>{7});
  WriteCacheFile(Files()[0], "7 8");  // two objects
  EXPECT_EQ(CountsForFill(kFilledBin, objects, {1}, 0.2), counts) << "measured again";
}

TEST_F(FillCounts, KeepsTheProportionsOfTheShares) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05), BoxObject({0.06, 0.02, 0.02}, 0.05)};
  const std::vector<int> counts = CountsForFill(kFilledBin, objects, {1, 3}, 0.4);
  ASSERT_EQ(counts.size(), 2u);
  EXPECT_NEAR(counts[1], 3.0 * counts[0], 2.0);
}

TEST_F(FillCounts, RefusesALevelThatOverflows) {
  // Each layer holds one plate, which covers half of the floor. A stack whose mean height is the
  // rim would be twice as high as the bin.
  const ObjectSet objects{BoxObject({0.12, 0.12, 0.03}, 0.2)};
  const std::string error = ErrorOf([&] { CountsForFill(kFilledBin, objects, {1}, 1.0); });
  EXPECT_NE(error.find("cannot be reached"), std::string::npos) << error;
}

// A few bricks fill the bin, and each drop stacks them in another way.
TEST_F(FillCounts, RefusesALevelThatDiffersFromDropToDrop) {
  const ObjectSet objects{BoxObject({0.1, 0.08, 0.06}, 0.2)};
  const std::string error = ErrorOf([&] { CountsForFill(kFilledBin, objects, {1}, 0.95); });
  EXPECT_NE(error.find("cannot be kept"), std::string::npos) << error;
}

TEST_F(FillCounts, RefusesATable) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.05)};
  const std::string error = ErrorOf([&] { CountsForFill(Bin{{0.2, 0.15, 0}}, objects, {1}, 0.5); });
  EXPECT_NE(error.find("table"), std::string::npos) << error;
}

}  // namespace
}  // namespace pickbed::tests
