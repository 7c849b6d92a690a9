#include "grasp/candidates/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "grasp/grippers/table.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

const GraspCandidateOptions kFewCandidates{.antipodal = {.candidates = 40, .max_pairs = 60},
                                           .robust = {.samples = 4}};

// A plate of 12 mm rests on the floor. A hand tilted by more than a few degrees would touch the
// floor before its contact is deep enough.
TEST(Candidates, RestingObjectHasVerticalCandidates) {
  auto plate = std::make_shared<ObjectModel>(*BoxObject({0.06, 0.012, 0.012}, 0.05));
  const auto count = [&] {
    Rng rng(1);
    const auto grasps = MakeCandidates(*plate, SmallJaw(), rng, kFewCandidates);
    return std::count_if(grasps.begin(), grasps.end(), [](const GraspCandidate& grasp) {
      const Eigen::Matrix3d& R_OG = grasp.X_OG.linear();
      const double tips_m = grasp.X_OG.translation().z();
      return R_OG(2, 2) < -1 + 1e-9 && std::abs(R_OG(2, 0)) < 1e-9 && tips_m > -0.006;
    });
  };
  EXPECT_EQ(count(), 0);
  plate->resting_O = {{Eigen::Vector3d::UnitZ(), 1}};
  EXPECT_GT(count(), 5);
}

// Every mechanism of the gripper table sets all qualities of its candidates.
TEST(Candidates, EachMechanismRatesItsCandidates) {
  for (const GripperRow& row : GripperTable()) {
    const std::unique_ptr<Gripper> gripper = row.make();
    Rng rng(1);
    GraspCandidateOptions options = kFewCandidates;
    options.suction.max_samples = 200;
    const auto grasps = MakeCandidates(*BoxObject({0.08, 0.05, 0.05}, 0.2), *gripper, rng, options);
    ASSERT_GT(grasps.size(), 10u) << row.name;
    double robust = 0, epsilon = 0;
    for (const GraspCandidate& grasp : grasps) {
      EXPECT_GT(grasp.quality, 0);
      robust = std::max(robust, grasp.robust);
      epsilon = std::max(epsilon, grasp.epsilon);
    }
    EXPECT_GT(robust, 0.5) << row.name;
    EXPECT_GT(epsilon, 0) << row.name;
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

TEST_F(CandidateCache, ReadsBackExactlyAndIsRemadeAfterDamage) {
  const auto object = BracketObject();
  const auto made = CachedCandidates(*object, SmallJaw(), kFewCandidates);
  const auto read = CachedCandidates(*object, SmallJaw(), kFewCandidates);
  ASSERT_EQ(Files().size(), 1u);
  std::filesystem::resize_file(Files().front(), 100);
  const auto remade = CachedCandidates(*object, SmallJaw(), kFewCandidates);
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

TEST_F(CandidateCache, GrippersHaveSeparateEntries) {
  CachedCandidates(*BracketObject(), SmallJaw(), kFewCandidates);
  ParallelJaw other = SmallJaw();
  other.hand.stroke_m = 0.07;
  CachedCandidates(*BracketObject(), other, kFewCandidates);
  EXPECT_EQ(Files().size(), 2u);
}

// Symmetries determine which resting directions are equivalent, and so the worth of a set-down.
TEST_F(CandidateCache, SymmetriesHaveSeparateEntries) {
  CachedCandidates(*BracketObject(), SmallJaw(), kFewCandidates);
  ObjectModel other = *BracketObject();
  other.symmetries_O.continuous_O.push_back({});
  CachedCandidates(other, SmallJaw(), kFewCandidates);
  EXPECT_EQ(Files().size(), 2u);
}

}  // namespace
}  // namespace pickbed::tests
