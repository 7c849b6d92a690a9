#include "grasp/tolerance/model_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "grasp/plan/plan.h"
#include "grasp/tolerance/tolerance_ranking.h"
#include "tests/grasp/grasp_scenes.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

// A bar of 20 cm along y, and a model in which only errors along the closing direction x matter.
class ToleranceRanking : public testing::Test {
 protected:
  ToleranceRanking() {
    model_ = EmptyToleranceModel(*bar_, "test jaw", {Pose::Identity()});
    SetWeight("1", 3);
    SetWeight("x**2", -20);
  }

  void SetWeight(const std::string& term, double weight) {
    const auto& terms = ToleranceTerms();
    const auto at = std::find(terms.begin(), terms.end(), term);
    ASSERT_NE(at, terms.end());
    model_.weights.at(at - terms.begin()) = weight;
  }

  // A grasp from above at `y_m` of the bar, closing along x.
  static Pose GraspAt(double y_m) { return FromAbove({0, y_m, 0.005}); }

  double Expected(double y_m, double position_m, double rotation_rad) const {
    return ExpectedSuccess(model_, *bar_, GraspAt(y_m), {position_m, rotation_rad}, 400);
  }

  std::shared_ptr<const ObjectModel> bar_ = BoxObject({0.02, 0.20, 0.03}, 0.2);
  ToleranceModel model_;
};

TEST_F(ToleranceRanking, WithoutUncertaintyItIsTheSuccessAtTheTruePose) {
  const double true_pose = SuccessProbability(model_, Pose::Identity(), GraspAt(0.05));
  EXPECT_NEAR(Expected(0.05, 0, 0), true_pose, 1e-12);
  EXPECT_NEAR(true_pose, 1 / (1 + std::exp(-3)), 1e-12);
}

TEST_F(ToleranceRanking, SuccessFallsWithTheUncertainty) {
  double last = 1;
  for (const double position_m : {0.0, 0.002, 0.005, 0.01}) {
    const double now = Expected(0, position_m, 0);
    EXPECT_LT(now, last);
    last = now;
  }
}

// A rotation error moves the ends of the bar further than its center.
TEST_F(ToleranceRanking, RotationErrorFavorsGraspsNearTheCenterOfMass) {
  EXPECT_GT(Expected(0, 0, 0.1), Expected(0.04, 0, 0.1) + 0.02);
  EXPECT_GT(Expected(0.04, 0, 0.1), Expected(0.08, 0, 0.1) + 0.02);
  EXPECT_NEAR(Expected(0, 0.003, 0), Expected(0.08, 0.003, 0), 1e-9)
      << "a shift is the same everywhere";
}

TEST_F(ToleranceRanking, PlannerPutsTheToleratedGraspFirst) {
  GraspCandidate strong, tolerated;
  strong.X_OG = GraspAt(0.06);
  tolerated.X_OG = GraspAt(0);
  for (GraspCandidate* candidate : {&strong, &tolerated}) {
    candidate->width_m = 0.02;
    candidate->depth_m = 0.01;
    candidate->tolerance = ExpectedSuccess(model_, *bar_, candidate->X_OG, {0.001, 0.1});
  }
  strong.quality = 0.9;
  tolerated.quality = 0.6;
  const Bin bin;
  const ObjectSet objects{bar_};
  const ParallelJaw jaw = SmallJaw();
  const std::vector<std::vector<GraspCandidate>> candidates{{strong, tolerated}};
  const std::vector<EstimatedPose> poses{{ObjectId{0}, Translation({0, 0, 0.016}), 1}};
  const auto first_y_m = [&](const std::string& ranking) {
    PlanOptions options;
    options.ranking = ranking;
    const PlanResult plan = PlanGrasps({bin, poses, candidates, {}, objects, jaw}, options);
    return plan.grasps.at(0).X_WG.translation().y();
  };
  EXPECT_NEAR(first_y_m("quality"), 0.06, 1e-9);
  EXPECT_NEAR(first_y_m("tolerance"), 0, 1e-9);
}

TEST_F(ToleranceRanking, CandidatesGetTheValueOfTheirMap) {
  const TemporaryFolder folder;
  WriteToleranceModel(folder.path() / kToleranceModelFile, model_);
  ScenarioSpec spec;
  const ObjectSet objects{bar_};
  GraspCandidate candidate;
  candidate.X_OG = GraspAt(0.04);
  std::vector<std::vector<GraspCandidate>> candidates{{candidate}};
  spec.policy.tolerance_maps = folder.path().string();
  FillTolerance(spec, objects, "test jaw", candidates);
  EXPECT_EQ(candidates[0][0].tolerance, 0) << "another ranking needs no maps";
  EXPECT_EQ(ToleranceRankingText(spec), "");
  spec.policy.ranking = kToleranceRanking;
  FillTolerance(spec, objects, "test jaw", candidates);
  const PoseUncertainty uncertainty{0.002, 2 * std::numbers::pi / 180};
  EXPECT_NEAR(candidates[0][0].tolerance,
              ExpectedSuccess(model_, *bar_, candidate.X_OG, uncertainty), 1e-12);
  // The identity of a run changes with the map.
  const std::string before = ToleranceRankingText(spec);
  SetWeight("1", 2);
  WriteToleranceModel(folder.path() / kToleranceModelFile, model_);
  EXPECT_NE(ToleranceRankingText(spec), before);
}

}  // namespace
}  // namespace pickbed::tests
