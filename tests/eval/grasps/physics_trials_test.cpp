#include "eval/grasps/physics_trials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "eval/grasps/report.h"
#include "scenes/base/files.h"
#include "sim/convex/convex_pieces.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A box of 4 x 3 x 6 cm, and grasps of it: across x near the top, beside it, and from below.
GraspTestJob BoxJob() {
  GraspTestJob job;
  job.object = BoxObject({0.04, 0.03, 0.06}, 0.1, 0.5);
  job.gripper = std::make_shared<ParallelJaw>(SmallJaw());
  const auto add = [&](const Pose& X_OG) {
    GraspCandidate candidate;
    candidate.X_OG = X_OG;
    candidate.width_m = 0.04;
    candidate.depth_m = 0.012;
    candidate.quality = 1;
    job.candidates.push_back(candidate);
  };
  add(FromAbove({0, 0, 0.006}));
  add(FromAbove({0, 0.08, 0.006}));
  add(FromAbove({0.03, 0, 0.006}));
  job.options.bins = 0;
  job.options.hold.max_g = 0;
  return job;
}

GraspFile FileOf(const GraspTestJob& job) {
  GraspFile file;
  file.file = "box.yaml";
  for (size_t i = 0; i < job.candidates.size(); ++i) {
    file.grasps.push_back(
        {"g" + std::to_string(i), job.candidates[i].X_OG, i == 0 ? 0.9 : 0.2, std::nullopt});
  }
  return file;
}

TEST(GraspTrials, GoodGraspsLiftAndBadOnesFailForTheirReason) {
  const GraspTestJob job = BoxJob();
  const GraspTests tests = TestGrasps(job);
  ASSERT_EQ(tests.tests.size(), 3u);
  EXPECT_TRUE(tests.tests[0].on_table.success);
  EXPECT_GE(tests.tests[0].place, 0) << "in a resting pose that leaves it free";
  EXPECT_FALSE(tests.tests[1].on_table.success);
  EXPECT_EQ(tests.tests[1].on_table.failure, FailureReason::kClosedOnNothing);
  EXPECT_FALSE(tests.tests[2].on_table.success);
  EXPECT_EQ(tests.tests[2].on_table.failure, FailureReason::kCollision)
      << "a finger lands on the box";
  const std::string text = GraspTestsText(FileOf(job), tests, job.options);
  EXPECT_THAT(text, HasSubstr("1 of 3 succeed"));
  EXPECT_THAT(text, HasSubstr("AUC of confidence  on the table 1.000"));
  const std::string csv = GraspTestsCsv(FileOf(job), tests);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 4);
  EXPECT_THAT(csv, HasSubstr("2,g2,0.2,"));
}

// A heavier object is lost at a smaller load. The load that friction holds is 2 mu F / (m g).
TEST(GraspTrials, TheHoldTestGrowsUntilTheObjectFalls) {
  GraspTestJob job = BoxJob();
  job.candidates.resize(1);
  job.options.hold = {.max_g = 100, .g_per_s = 20};
  const auto retention_g = [&](double mass_kg) {
    job.object = BoxObject({0.04, 0.03, 0.06}, mass_kg, 0.5);
    return TestGrasps(job).tests.at(0).on_table.retention_g;
  };
  const double light_g = retention_g(0.1), heavy_g = retention_g(0.4);
  EXPECT_NEAR(light_g, 2 * 0.5 * 40 / (0.1 * 9.81), 0.25 * light_g);
  EXPECT_NEAR(heavy_g, light_g / 4, 0.3 * heavy_g);
  job.options.hold.max_g = 2;
  EXPECT_EQ(retention_g(0.1), 2) << "held to the end";
}

TEST(GraspTrials, BinsDoNotDependOnTheNumberOfWorkers) {
  GraspTestJob job = BoxJob();
  // A cube, and a grasp from each side. The last grasp is beside it.
  job.object = BoxObject({0.03, 0.03, 0.03}, 0.05, 0.6);
  const GraspCandidate top = job.candidates[0];
  job.candidates.clear();
  const auto add = [&](const Eigen::AngleAxisd& rotation, double aside_m) {
    GraspCandidate& candidate = job.candidates.emplace_back(top);
    candidate.width_m = 0.03;
    candidate.X_OG = MakePose(rotation.toRotationMatrix(), Eigen::Vector3d::Zero()) *
                     FromAbove({0, aside_m, -0.006});
  };
  for (const double angle : {0.0, 0.5, 1.0, 1.5}) {
    add(Eigen::AngleAxisd(angle * std::numbers::pi, Eigen::Vector3d::UnitX()), 0);
  }
  for (const double angle : {0.5, 1.5}) {
    add(Eigen::AngleAxisd(angle * std::numbers::pi, Eigen::Vector3d::UnitY()), 0);
  }
  add(Eigen::AngleAxisd(0, Eigen::Vector3d::UnitX()), 0.06);
  job.options.bins = 2;
  job.options.instances = 4;
  const std::string one = GraspTestsCsv(FileOf(job), TestGrasps(job));
  job.jobs = 2;
  const GraspTests tests = TestGrasps(job);
  EXPECT_EQ(GraspTestsCsv(FileOf(job), tests), one);
  Cluster good;
  for (size_t i = 0; i + 1 < tests.tests.size(); ++i) {
    good.hits += SumOf(tests.tests[i].in_bins).hits;
    good.samples += SumOf(tests.tests[i].in_bins).samples;
  }
  EXPECT_GE(good.samples, 2) << "some side of a cube is up";
  EXPECT_GE(good.hits, good.samples - 2);
  EXPECT_EQ(SumOf(tests.tests.back().in_bins).hits, 0);
  EXPECT_THAT(GraspTestsText(FileOf(job), tests, job.options), HasSubstr("in 2 bins of 4"));
}

TEST(GraspTrials, OfManyGraspsAnEvenSelectionIsTested) {
  GraspTestJob job = BoxJob();
  job.candidates.resize(1);
  job.candidates.resize(10, job.candidates[0]);
  job.options.max_grasps = 3;
  job.options.execute.carry = false;
  const GraspTests tests = TestGrasps(job);
  ASSERT_EQ(tests.tests.size(), 3u);
  EXPECT_EQ(tests.tests[0].grasp, 0);
  EXPECT_EQ(tests.tests[1].grasp, 3);
  EXPECT_EQ(tests.tests[2].grasp, 6);
  job.options.max_grasps = 0;
  EXPECT_THAT(ErrorOf([&] { TestGrasps(job); }), HasSubstr("max_grasps = 0"));
}

TEST(GraspTrials, AStopGivesNoResults) {
  GraspTestJob job = BoxJob();
  job.stop = [] { return true; };
  const GraspTests tests = TestGrasps(job);
  EXPECT_TRUE(tests.interrupted);
  EXPECT_TRUE(tests.tests.empty());
}

}  // namespace
}  // namespace pickbed::tests
