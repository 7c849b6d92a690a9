#include "perception/icp/final_refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "perception/verify/pose_features.h"
#include "tests/support/cloud_options.h"
#include "tests/support/error_of.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A bracket in front of a wall, with hypotheses near it and one far away from everything.
class FinalRefinement : public ::testing::Test {
 protected:
  FinalRefinement() : object_(ObjectOf(BracketMesh())), models_{MakeModelPoints(*object_)} {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, BracketPose());
    scene.AddPlane({0, 0, -1}, {0, 0, 1.0});
    cloud_ = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
    Rng rng(1);
    for (int i = 0; i < 6; ++i) {
      PoseHypothesis& h = hypotheses_.emplace_back();
      h.X_CO = Perturbed(BracketPose(), rng.UnitVector(), 3, 0.002 * rng.UnitVector());
    }
    hypotheses_.emplace_back().X_CO = Translation({0.3, 0, 0.4});
  }
  std::vector<PoseHypothesis> RefinedBy(const std::string& refiner, int threads = 1) const {
    std::vector<PoseHypothesis> refined = hypotheses_;
    RefineFinally(refiner, cloud_, models_, threads, refined);
    return refined;
  }
  std::shared_ptr<const ObjectModel> object_;
  std::vector<ModelPoints> models_;
  OrganizedCloud cloud_;
  std::vector<PoseHypothesis> hypotheses_;
};

class EachRefiner : public FinalRefinement, public testing::WithParamInterface<const char*> {};

TEST_P(EachRefiner, ImprovesPosesAndReportsTheirFit) {
  const std::vector<PoseHypothesis> refined = RefinedBy(GetParam());
  for (size_t i = 0; i + 1 < refined.size(); ++i) {
    const PoseHypothesis& h = refined[i];
    EXPECT_TRUE(h.fit.refinement_kept) << i;
    ASSERT_TRUE(h.unrefined_X_CO.has_value()) << i;
    EXPECT_EQ(h.unrefined_X_CO->matrix(), hypotheses_[i].X_CO.matrix()) << i;
    EXPECT_LT(GapBetween(h.X_CO, BracketPose()).angle_deg, 1) << i;
    EXPECT_LT(GapBetween(h.X_CO, BracketPose()).shift_m, 0.001) << i;
    EXPECT_EQ(h.fit.inlier_share, MeasureFit(cloud_, models_[0], h.X_CO).inlier_share) << i;
    EXPECT_GT(h.fit.reciprocal_condition_number, 0) << i;
  }
}

TEST_P(EachRefiner, PoseWithoutCorrespondencesIsUnchanged) {
  const PoseHypothesis lost = RefinedBy(GetParam()).back();
  EXPECT_FALSE(lost.fit.refinement_kept);
  EXPECT_FALSE(lost.unrefined_X_CO.has_value());
  EXPECT_EQ(lost.X_CO.matrix(), hypotheses_.back().X_CO.matrix());
  EXPECT_EQ(lost.fit.reciprocal_condition_number, 0);
}

TEST_P(EachRefiner, ResultIsIndependentOfThreads) {
  const std::vector<PoseHypothesis> one = RefinedBy(GetParam(), 1),
                                    three = RefinedBy(GetParam(), 3);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].X_CO.matrix(), three[i].X_CO.matrix()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Refiners, EachRefiner,
                         testing::Values("pcl_icp", "bidirectional_icp", "projective_icp"));

TEST_F(FinalRefinement, NoneChangesNothing) {
  hypotheses_[0].fit.inlier_share = 0.123;
  const PoseHypothesis same = RefinedBy("none").front();
  EXPECT_EQ(same.X_CO.matrix(), hypotheses_[0].X_CO.matrix());
  EXPECT_EQ(same.fit.inlier_share, 0.123);
  EXPECT_FALSE(same.unrefined_X_CO.has_value());
}

TEST_F(FinalRefinement, OptionsOfARefinerAreUsedAndChecked) {
  const auto refiner = RefinerNamed("bidirectional_icp").make();
  const auto visit = [&](SettingsVisitor& v) { refiner->Visit(v); };
  ApplySetting("iterations=0", visit);
  ApplySetting("restart_rad=0", visit);
  std::vector<PoseHypothesis> refined = hypotheses_;
  RefineFinally(*refiner, cloud_, models_, 1, refined);
  EXPECT_TRUE(refined[0].X_CO.isApprox(hypotheses_[0].X_CO, 1e-9));
  EXPECT_FALSE(RefinedBy("bidirectional_icp")[0].X_CO.isApprox(hypotheses_[0].X_CO, 1e-3));
  EXPECT_THAT(ErrorOf([&] { ApplySetting("restart_rad=4", visit); }), HasSubstr("restart_rad"));
}

TEST_F(FinalRefinement, UnknownNameIsRefusedAndKnownOnesAreListed) {
  hypotheses_.clear();  // refused even if there is nothing to refine
  EXPECT_THAT(ErrorOf([&] { RefinedBy("pcl_ipc"); }),
              testing::AllOf(HasSubstr("pcl_ipc"), HasSubstr("did you mean 'pcl_icp'"),
                             HasSubstr("bidirectional_icp"), HasSubstr("none")));
}

TEST(RefinerTable, NamesAreDistinctAndHaveHelp) {
  std::set<std::string> names;
  for (const RefinerRow& row : RefinerTable()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_STRNE(row.help, "") << row.name;
    EXPECT_EQ(&RefinerNamed(row.name), &row);
  }
}

}  // namespace
}  // namespace pickbed::tests
