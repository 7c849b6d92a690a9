#include "perception/verify/depth_evidence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/sim/render_support.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A bracket seen by a camera that casts rays, without the rasteriser.
class BracketView : public ::testing::Test {
 protected:
  BracketView() : object_(ObjectOf(BracketMesh())) {}

  RgbdFrame Render(const Pose& X_CO) const {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, X_CO);
    return scene.frame();
  }

  DepthEvidence EvidenceFor(const RgbdFrame& frame, const Pose& X_CO,
                            const DepthEvidenceOptions& options = {}) const {
    EvidenceScratch scratch;
    return DepthEvidenceOf(*object_, options)(BuildCloud(frame, std::nullopt, kKeepAll), X_CO,
                                              scratch);
  }

  static double Readings(const RgbdFrame& frame) {
    double count = 0;
    for (size_t i = 0; i < frame.depth_m.size(); ++i) count += frame.depth_m.data()[i] > 0;
    return count;
  }

  std::shared_ptr<const ObjectModel> object_;
};

TEST_F(BracketView, CoversThePixelsThatRaysHit) {
  const RgbdFrame frame = Render(BracketPose());
  const DepthEvidence e = EvidenceFor(frame, BracketPose());
  EXPECT_NEAR(e.covered, Readings(frame), 0.02 * Readings(frame));
  EXPECT_GT(e.agreeing, 0.95 * e.covered);
  EXPECT_EQ(e.hidden, 0);
}

// On the surface, each pixel contributes the log of the mixture at its peak.
TEST_F(BracketView, ExactReadingsContributeTheMixturePeak) {
  const RgbdFrame frame = Render(BracketPose());
  const DepthEvidenceOptions options;
  const DepthEvidence e = EvidenceFor(frame, BracketPose(), options);
  const double peak = object_->diameter_m / (std::sqrt(2 * std::numbers::pi) * options.sigma_m);
  const double nats =
      std::log((1 - options.occlusion) * peak + options.occlusion + options.outlier);
  const double costs = options.violated_cost * e.violated + options.hidden_cost * e.hidden +
                       options.wrong_normal_cost * e.wrong_normal +
                       options.continuing_cost * e.continuing;
  EXPECT_NEAR((e.log_ratio + costs) / e.agreeing, nats, 0.02 * nats);
}

TEST_F(BracketView, InFrontIsViolatedAndBehindIsHidden) {
  const RgbdFrame frame = Render(BracketPose());
  const DepthEvidence before = EvidenceFor(frame, Translation({0, 0, -0.05}) * BracketPose());
  EXPECT_GT(before.violated, 0.6 * before.covered);
  EXPECT_LT(before.log_ratio, -before.covered);
  const DepthEvidence behind = EvidenceFor(frame, Translation({0, 0, 0.05}) * BracketPose());
  EXPECT_GT(behind.hidden, 0.9 * behind.covered);
  EXPECT_LT(behind.log_ratio, 0);
  EXPECT_GT(behind.log_ratio, -behind.covered);  // a hidden surface is no contradiction
}

TEST_F(BracketView, HolesContributeNothing) {
  RgbdFrame frame = Render(BracketPose());
  for (size_t i = 0; i < frame.depth_m.size(); ++i) frame.depth_m.data()[i] = 0;
  const DepthEvidence e = EvidenceFor(frame, BracketPose());
  EXPECT_GT(e.covered, 0);
  EXPECT_EQ(e.log_ratio, 0);
  EXPECT_EQ(e.agreeing + e.hidden + e.violated + e.wrong_normal, 0);
}

// A box that shows one face, in front of a wall or flush with it.
TEST(OutlineEvidence, ContinuingSurfaceLowersTheEvidence) {
  const auto box = ObjectOf(BoxMesh({0.061, 0.041, 0.02}, {0, 0, 0.01}));
  const Pose X_CO = Translation({0, 0, 0.4});
  const auto evidence = [&](const SyntheticDepth& scene) {
    EvidenceScratch scratch;
    return DepthEvidenceOf(*box)(BuildCloud(scene.frame(), std::nullopt, kKeepAll), X_CO, scratch);
  };
  SyntheticDepth flush(SmallCamera());
  flush.AddPlane(-Eigen::Vector3d::UnitZ(), X_CO.translation());
  const DepthEvidence of_wall = evidence(flush);
  EXPECT_GT(of_wall.agreeing, 0.95 * of_wall.covered);
  // On each side, three pixels at the rim of the face are compared with the surface beyond it.
  const double rim_px = 2 * (0.061 + 0.041) / 0.4 * SmallCamera().fx();
  EXPECT_NEAR(of_wall.beyond, 3 * rim_px, 0.1 * 3 * rim_px);
  EXPECT_EQ(of_wall.continuing, of_wall.beyond);

  SyntheticDepth before_wall(SmallCamera());
  before_wall.AddPlane(-Eigen::Vector3d::UnitZ(), {0, 0, 0.5});
  before_wall.AddMesh(box->mesh_O, X_CO);
  const DepthEvidence separate = evidence(before_wall);
  EXPECT_NEAR(separate.beyond, of_wall.beyond, 0.05 * of_wall.beyond);
  EXPECT_EQ(separate.continuing, 0);
  EXPECT_NEAR(separate.log_ratio - of_wall.log_ratio,
              DepthEvidenceOptions().continuing_cost * of_wall.continuing,
              0.01 * separate.log_ratio);

  // An occluder in front of the outline gives no information about it.
  SyntheticDepth half_hidden(SmallCamera());
  half_hidden.AddPlane(-Eigen::Vector3d::UnitZ(), X_CO.translation());
  half_hidden.AddMesh(BoxMesh({0.4, 0.3, 0.02}, {0.215, 0, 0.3}), Pose::Identity());
  const DepthEvidence half = evidence(half_hidden);
  EXPECT_GT(half.hidden, 0.1 * half.covered);
  EXPECT_LT(half.beyond, 0.85 * of_wall.beyond);
  EXPECT_EQ(half.continuing, half.beyond);
}

// A plane through the object's center, where the object has sides of other slants.
TEST_F(BracketView, OtherSlantIsAWrongNormal) {
  SyntheticDepth scene(SmallCamera());
  const Eigen::Vector3d center_C = BracketPose() * MeshBounds(object_->mesh_O).center();
  scene.AddPlane({std::sin(1.0), 0, -std::cos(1.0)}, center_C);
  EXPECT_GT(EvidenceFor(scene.frame(), BracketPose()).wrong_normal, 20);
}

TEST_F(BracketView, GroundTruthHasTheMostEvidence) {
  Rng rng(3);
  const RgbdFrame frame = WithNoise(Render(BracketPose()), 0.001, rng);
  const double truth = EvidenceFor(frame, BracketPose()).log_ratio;
  for (int i = 0; i < 100; ++i) {
    const Pose other = Perturbed(BracketPose(), rng.UnitVector(), rng.Uniform(5, 180),
                                 rng.Uniform(0, 0.01) * rng.UnitVector());
    EXPECT_LT(EvidenceFor(frame, other).log_ratio, truth);
  }
}

TEST_F(BracketView, FewPixelsGiveTheEvidenceOfAll) {
  const RgbdFrame frame = Render(BracketPose());
  DepthEvidenceOptions few;
  few.max_pixels = 300;
  const DepthEvidence all = EvidenceFor(frame, BracketPose());
  const DepthEvidence some = EvidenceFor(frame, BracketPose(), few);
  EXPECT_NE(some.covered, all.covered);
  EXPECT_NEAR(some.covered, all.covered, 0.1 * all.covered);
  EXPECT_NEAR(some.log_ratio, all.log_ratio, 0.1 * all.log_ratio);
}

// A mesh of many triangles is drawn at a coarser level, which must still match the object.
TEST(DepthEvidence, SimplifiedMeshGivesTheSameEvidence) {
  const auto ball = ObjectOf(SphereMesh(0.03, 5));
  ASSERT_GT(ball->mesh_O.triangles.size(), 15000u);
  const Pose X_CO = Translation({0.01, 0.02, 0.5});
  SyntheticDepth scene(SmallCamera());
  scene.AddSphere(X_CO.translation(), 0.03);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  EvidenceScratch scratch;
  const DepthEvidence e = DepthEvidenceOf(*ball)(cloud, X_CO, scratch);
  const double seen = static_cast<double>(cloud.foreground_pixels.size());
  EXPECT_NEAR(e.covered, seen, 0.03 * seen);
  EXPECT_GT(e.agreeing, 0.93 * e.covered);
}

TEST_F(BracketView, OutOfViewContributesNothing) {
  const RgbdFrame frame = Render(BracketPose());
  for (const Eigen::Vector3d& shift_m :
       {Eigen::Vector3d(5, 0, 0), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0, 0, -10)}) {
    const DepthEvidence e = EvidenceFor(frame, Translation(shift_m) * BracketPose());
    EXPECT_EQ(e.covered, 0);
    EXPECT_EQ(e.log_ratio, 0);
  }
}

}  // namespace
}  // namespace pickbed::tests
