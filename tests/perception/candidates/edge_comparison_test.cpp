#include "perception/candidates/edge_comparison.h"

#include <gtest/gtest.h>

#include <numbers>

#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "tests/perception/edge_image.h"

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

}  // namespace
}  // namespace pickbed::tests
