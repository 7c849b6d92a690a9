#include "grasp/candidates.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "scenes/check.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/temporary_folder.h"

namespace pickbed {
namespace {

const GraspCandidateOptions kQuick{.antipodal = {.candidates = 40, .max_pairs = 60},
                                   .robust = {.samples = 4}};

TEST(Candidates, EveryMechanismHasAMaker) {
  for (const MechanismRow& row : MechanismTable()) {
    GripperSpec gripper;
    gripper.mechanism = row.name;
    EXPECT_STREQ(CandidateMakerOf(gripper).mechanism, row.name);
  }
  EXPECT_EQ(CandidateMakerTable().size(), MechanismTable().size());
}

TEST(Candidates, UnknownMechanismIsRefused) {
  GripperSpec gripper;
  gripper.name = "odd";
  gripper.mechanism = "magnet";
  EXPECT_THROW(CandidateMakerOf(gripper), InputError);
}

// Through the table alone, whatever the mechanism: every quality is set.
TEST(Candidates, OfEachMechanismAreJudged) {
  GripperSpec cup;
  cup.mechanism = "suction_cup";
  for (const GripperSpec& gripper : {SmallJaw(), cup}) {
    Rng rng(1);
    GraspCandidateOptions options = kQuick;
    options.suction.max_samples = 200;
    const auto grasps = MakeCandidates(*BoxPart({0.08, 0.05, 0.05}, 0.2), gripper, rng, options);
    ASSERT_GT(grasps.size(), 10u) << gripper.mechanism;
    double robust = 0, epsilon = 0;
    for (const GraspCandidate& grasp : grasps) {
      EXPECT_GT(grasp.quality, 0);
      robust = std::max(robust, grasp.robust);
      epsilon = std::max(epsilon, grasp.epsilon);
    }
    EXPECT_GT(robust, 0.5) << gripper.mechanism;
    EXPECT_GT(epsilon, 0) << gripper.mechanism;
  }
}

class CandidateCache : public testing::Test {
 protected:
  CandidateCache() { setenv("XDG_CACHE_HOME", folder_.c_str(), 1); }
  ~CandidateCache() override { unsetenv("XDG_CACHE_HOME"); }

  std::vector<std::filesystem::path> Files() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "pickbed" / "grasps")) {
      files.push_back(entry.path());
    }
    return files;
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

TEST_F(CandidateCache, ComesBackTheSameFromDiskAndAfterDamage) {
  const auto part = BracketPart();
  const auto made = CachedCandidates(*part, SmallJaw(), kQuick);
  const auto read = CachedCandidates(*part, SmallJaw(), kQuick);
  ASSERT_EQ(Files().size(), 1u);
  std::filesystem::resize_file(Files().front(), 100);
  const auto remade = CachedCandidates(*part, SmallJaw(), kQuick);
  ASSERT_EQ(made.size(), read.size());
  ASSERT_EQ(made.size(), remade.size());
  for (size_t i = 0; i < made.size(); ++i) {
    EXPECT_EQ(made[i].X_OG.matrix(), read[i].X_OG.matrix());
    EXPECT_EQ(made[i].width_m, read[i].width_m);
    EXPECT_EQ(made[i].quality, remade[i].quality);
    EXPECT_EQ(made[i].epsilon, read[i].epsilon);
    EXPECT_EQ(made[i].robust, read[i].robust);
    EXPECT_EQ(made[i].epsilon, remade[i].epsilon);
    EXPECT_EQ(made[i].robust, remade[i].robust);
  }
}

TEST_F(CandidateCache, OtherGripperOtherEntry) {
  CachedCandidates(*BracketPart(), SmallJaw(), kQuick);
  GripperSpec other = SmallJaw();
  other.hand.stroke_m = 0.07;
  CachedCandidates(*BracketPart(), other, kQuick);
  EXPECT_EQ(Files().size(), 2u);
}

}  // namespace
}  // namespace pickbed
