#include "perception/estimators/ppf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// Three separate brackets on a table. OpenCV needs seconds to train on an object, so all tests
// share one estimator.
class BracketsOnATable : public ::testing::Test {
 protected:
  static constexpr double kMinScore = 0.3;

  static void SetUpTestSuite() {
    object_ = ObjectOf(BracketMesh());
    EstimatorSetup setup;
    setup.objects = {object_};
    setup.spec.name = "ppf";
    setup.spec.min_score = kMinScore;
    estimator_ = MakePpfEstimator(setup);
  }
  static void TearDownTestSuite() { estimator_.reset(); }

  BracketsOnATable() {
    background_.bin.inner_size_m.z() = 0;
    background_.X_CB = LookAt({0, -0.1, 0.5}, {0, 0, 0}, {0, 0, 1}).inverse();
    for (const double angle : {0.3, 2.0, 4.1}) {
      Pose X_BO(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
      X_BO.translation() << 0.09 * std::cos(2 * angle), 0.07 * std::sin(2 * angle), 0.0205;
      truth_.push_back(background_.X_CB * X_BO);
    }
  }

  EstimateResult Run(const std::vector<Pose>& poses, std::vector<int> instances = {}) const {
    const CameraIntrinsics k(480, 360, 600, 600, 239.5, 179.5);
    SyntheticDepth scene(k);
    scene.AddPlane(background_.X_CB.linear().col(2), background_.X_CB.translation());
    for (const Pose& X_CO : poses) scene.AddMesh(object_->mesh_O, X_CO);
    Rng noise(1), rng(0);
    return estimator_->Estimate(
        {WithNoise(scene.frame(), 0.0005, noise), background_, nullptr, std::move(instances)}, rng);
  }

  static inline std::shared_ptr<const ObjectModel> object_;
  static inline std::unique_ptr<PoseEstimator> estimator_;
  KnownBackground background_;
  std::vector<Pose> truth_;
};

// Two of the three are enough: the voting is known to miss some.
TEST_F(BracketsOnATable, FindsMostInstancesAndNoFalsePose) {
  const EstimateResult result = Run(truth_);
  std::set<size_t> found;
  for (const PoseHypothesis& h : result.hypotheses) {
    for (size_t i = 0; i < truth_.size(); ++i) {
      const PoseGap gap = GapBetween(h.X_CO, truth_[i]);
      if (gap.shift_m < 0.003 && gap.angle_deg < 5) found.insert(i);
    }
  }
  EXPECT_GE(found.size(), 2u);
  EXPECT_EQ(found.size(), result.hypotheses.size());
  EXPECT_TRUE(std::is_sorted(
      result.hypotheses.begin(), result.hypotheses.end(),
      [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.score > b.score; }));
  for (const PoseHypothesis& h : result.hypotheses) {
    EXPECT_GE(h.score, kMinScore);
    EXPECT_LE(h.score, 1.0);
  }
  for (const char* stage :
       {"cloud", "match", "icp", "verify", "non_maximum_suppression", "refine"}) {
    EXPECT_TRUE(result.seconds.contains(stage)) << stage;
  }
}

TEST_F(BracketsOnATable, KnownCountReportsTheBest) {
  const EstimateResult all = Run(truth_), one = Run(truth_, {1});
  ASSERT_GE(all.hypotheses.size(), 2u);
  ASSERT_EQ(one.hypotheses.size(), 1u);
  EXPECT_EQ(one.hypotheses[0].score, all.hypotheses[0].score);
}

TEST_F(BracketsOnATable, SameFrameSamePoses) {
  const EstimateResult a = Run({truth_[2]}), b = Run({truth_[2]});
  ASSERT_FALSE(a.hypotheses.empty());
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (size_t i = 0; i < a.hypotheses.size(); ++i) {
    EXPECT_EQ(a.hypotheses[i].X_CO.matrix(), b.hypotheses[i].X_CO.matrix());
  }
}

// All points have the same z, by whose extent the matcher divides.
TEST_F(BracketsOnATable, ConstantDepthGivesNoHypothesis) {
  RgbdFrame frame;
  frame.intrinsics = {480, 360, 600, 600, 239.5, 179.5};
  frame.color = Image<Rgb8>(480, 360);
  frame.depth_m = Image<float>(480, 360, 0.4f);
  Rng rng(0);
  EXPECT_TRUE(estimator_->Estimate({frame, background_}, rng).hypotheses.empty());
}

TEST_F(BracketsOnATable, EmptyTableGivesNoHypothesis) { EXPECT_TRUE(Run({}).hypotheses.empty()); }

}  // namespace
}  // namespace pickbed::tests
