#include "perception/candidates/edge_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "perception/verify/edge_support.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "tests/perception/edge_image.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A flange whose depth image is nearly the same when it is turned by 30 degrees, half the angle
// between its bolt holes.
class EdgeComparison : public testing::Test {
 protected:
  EdgeComparison()
      : flange_(ObjectCatalog({AssetsDir() / "objects"}).Load("flange")),
        models_{MakeModelPoints(*flange_)},
        distances_{PoseDistance(*flange_)},
        cloud_(CloudWithEdgesOf(camera_, models_[0], X_CO_)) {}

  static Pose Turned(double angle_rad) {
    return Pose(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()));
  }
  void Add(const Pose& X_CO, double score) {
    candidates_.emplace_back();
    candidates_.back().hypothesis.X_CO = X_CO;
    scores_.push_back(score);
  }
  void Weigh() { WeighByEdges(cloud_, models_, distances_, candidates_, scores_); }

  const CameraIntrinsics camera_{640, 480, 1800, 1800, 319.5, 239.5};
  const Pose X_CO_ =
      MakePose(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()).toRotationMatrix(), {0, 0, 0.8});
  std::shared_ptr<const ObjectModel> flange_;
  std::vector<ModelPoints> models_;
  std::vector<PoseDistance> distances_;
  OrganizedCloud cloud_;
  std::vector<Candidate> candidates_;
  std::vector<double> scores_;
};

TEST_F(EdgeComparison, AmbiguousPosesAreToldApart) {
  Add(X_CO_ * Turned(std::numbers::pi / 6), 0.5);
  Add(X_CO_, 0.4);
  Weigh();
  EXPECT_LT(scores_[0], 0.1);
  EXPECT_GT(scores_[1], 0.8);
  EXPECT_NEAR(scores_[0] + scores_[1], 0.9, 1e-9) << "the sum stays";
}

TEST_F(EdgeComparison, SumOfAmbiguousPosesIsAtMostOne) {
  Add(X_CO_ * Turned(std::numbers::pi / 6), 0.9);
  Add(X_CO_, 0.9);
  Weigh();
  EXPECT_NEAR(scores_[0] + scores_[1], 1, 1e-9);
}

TEST_F(EdgeComparison, EqualPosesAreOneAlternative) {
  Add(X_CO_, 0.6);
  Add(X_CO_ * Turned(2 * std::numbers::pi / 6), 0.5);  // the same by symmetry
  Weigh();
  EXPECT_EQ(scores_, (std::vector<double>{0.6, 0.5}));
}

TEST_F(EdgeComparison, OtherPlacesAndObjectsKeepTheirScores) {
  Add(X_CO_, 0.6);
  Add(Translation({0.03, 0, 0}) * X_CO_ * Turned(std::numbers::pi / 6), 0.5);
  Weigh();
  EXPECT_EQ(scores_, (std::vector<double>{0.6, 0.5})) << "another instance";
  models_.push_back(models_[0]);
  distances_.push_back(distances_[0]);
  candidates_[1].hypothesis.X_CO = X_CO_ * Turned(std::numbers::pi / 6);
  candidates_[1].hypothesis.object = ObjectId(1);
  Weigh();
  EXPECT_EQ(scores_, (std::vector<double>{0.6, 0.5})) << "another object";
}

TEST_F(EdgeComparison, ScoresStayWithoutColor) {
  Add(X_CO_ * Turned(std::numbers::pi / 6), 0.5);
  Add(X_CO_, 0.4);
  cloud_.edges = {};
  Weigh();
  EXPECT_EQ(scores_, (std::vector<double>{0.5, 0.4}));
}

// A tilted box with sharp edges on its front only. Turned over, it shows one of them.
TEST_F(EdgeComparison, PosesThatShowOtherEdgesAreNotCompared) {
  ObjectModel box;
  box.mesh_O = BoxMesh({0.06, 0.06, 0.02}, Eigen::Vector3d::Zero());
  box.diameter_m = std::hypot(0.06, 0.06, 0.02);
  models_ = {MakeModelPoints(box)};
  distances_ = {PoseDistance(box)};
  std::erase_if(models_[0].edges, [](const EdgePoint& point) { return point.p_O.z() < 0.0099f; });
  const Pose X_turned = X_CO_ * Pose(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  cloud_ = CloudWithEdgesOf(camera_, models_[0], X_turned);
  const int shown = MeasureEdgeSupport(cloud_, models_[0], X_CO_).visible;
  const int shown_turned = MeasureEdgeSupport(cloud_, models_[0], X_turned).visible;
  ASSERT_GT(std::min(shown, shown_turned), 40);
  ASSERT_GT(std::abs(shown - shown_turned), 0.3 * std::max(shown, shown_turned));
  Add(X_CO_, 0.5);
  Add(X_turned, 0.4);
  Weigh();
  EXPECT_NEAR(scores_[0], 0.5, 1e-12);
  EXPECT_NEAR(scores_[1], 0.4, 1e-12);
}

// The depth shows that a mug is turned by 17 degrees about the center of its box.
TEST_F(EdgeComparison, PosesWithOtherDepthAreNotCompared) {
  const auto mug = ObjectCatalog({AssetsDir() / "objects"}).Load("mug");
  models_ = {MakeModelPoints(*mug)};
  distances_ = {PoseDistance(*mug)};
  const Pose X_turned = X_CO_ * Turned(0.3);
  cloud_ = CloudWithEdgesOf(camera_, models_[0], X_CO_);
  const EdgeSupport right = MeasureEdgeSupport(cloud_, models_[0], X_CO_);
  const EdgeSupport wrong = MeasureEdgeSupport(cloud_, models_[0], X_turned);
  ASSERT_GT(std::min(right.visible, wrong.visible), 40);
  ASSERT_GT(right.mean, 1.5 * wrong.mean) << "compared, the edges would decide";
  Add(X_turned, 0.5);
  Add(X_CO_, 0.4);
  Weigh();
  EXPECT_EQ(scores_, (std::vector<double>{0.5, 0.4}));
}

}  // namespace
}  // namespace pickbed::tests
