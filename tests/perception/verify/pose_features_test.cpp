#include "perception/verify/pose_features.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "perception/networks/verifier_file.h"
#include "scenes/base/random.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

// A slab of 80 x 80 x 20 mm that faces the camera at 0.4 m, with nothing behind it.
class SlabView : public ::testing::Test {
 protected:
  SlabView()
      : object_(ObjectOf(BoxMesh({0.08, 0.08, 0.02}, Eigen::Vector3d::Zero()))),
        model_(MakeModelPoints(*object_)),
        X_CO_(Translation({0, 0, 0.4})) {}

  RgbdFrame Render() const {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, X_CO_);
    return scene.frame();
  }

  FitReport FitOf(const RgbdFrame& frame) const {
    return MeasureFit(BuildCloud(frame, std::nullopt, kKeepAll), model_, X_CO_);
  }

  VerifyFeatures FeaturesOf(const RgbdFrame& frame, const Pose& X_CO, double votes = 0) const {
    FitReport fit;
    EvidenceScratch scratch;
    const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
    const DepthEvidence evidence = DepthEvidenceOf(*object_)(cloud, X_CO, scratch);
    return ComputeVerifyFeatures(cloud, model_, X_CO, evidence, {}, votes, fit);
  }

  // Sets depth where the camera sees the slab's left half.
  static void PaintLeftHalf(RgbdFrame& frame, float depth_m) {
    for (int y = 0; y < frame.depth_m.height(); ++y) {
      for (int x = 0; x < frame.depth_m.width() / 2; ++x) frame.depth_m(x, y) = depth_m;
    }
  }

  std::shared_ptr<const ObjectModel> object_;
  ModelPoints model_;
  Pose X_CO_;
};

TEST_F(SlabView, TruePoseHasOnlyInliers) {
  const FitReport fit = FitOf(Render());
  EXPECT_GT(fit.inlier_share, 0.95);
  EXPECT_LT(fit.hidden_share + fit.violated_share, 0.02);
  EXPECT_LT(fit.residual_m, 1e-4);
}

// Planted cases: half of the slab is occluded, seen through or unknown.
TEST_F(SlabView, OccludedPointsAreHidden) {
  RgbdFrame frame = Render();
  PaintLeftHalf(frame, 0.3f);
  const FitReport fit = FitOf(frame);
  EXPECT_NEAR(fit.hidden_share, 0.5, 0.06);
  EXPECT_NEAR(fit.inlier_share, 0.5, 0.06);
  EXPECT_LT(fit.violated_share, 0.01);
}

// The points that are drawn one by one add up to the features. Planted cases: half of the slab is
// occluded, seen through or unknown, and a rotated slab has other normals.
TEST_F(SlabView, JudgedPointsAddUpToTheFeatures) {
  for (const float painted_m : {0.3f, 0.6f, 0.0f}) {
    for (const double rotation_deg : {0.0, 50.0}) {
      RgbdFrame frame = Render();
      PaintLeftHalf(frame, painted_m);
      const Pose X_CO =
          Perturbed(X_CO_, Eigen::Vector3d::UnitX(), rotation_deg, Eigen::Vector3d::Zero());
      const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
      FitReport fit;
      const VerifyFeatures features = ComputeVerifyFeatures(cloud, model_, X_CO, {}, {}, 0, fit);
      const std::vector<JudgedPoint> points = JudgePoints(cloud, model_, X_CO);
      const auto share = [&](PointFit wanted) {
        const auto count = std::count_if(points.begin(), points.end(),
                                         [&](const JudgedPoint& p) { return p.fit == wanted; });
        return static_cast<float>(static_cast<double>(count) / points.size());
      };
      SCOPED_TRACE(testing::Message() << painted_m << " m, " << rotation_deg << " degrees");
      EXPECT_EQ(share(PointFit::kAgrees), features[0]);
      EXPECT_EQ(share(PointFit::kHidden), features[1]);
      EXPECT_EQ(share(PointFit::kViolates), features[2]);
      EXPECT_EQ(share(PointFit::kWrongNormal), features[3]);
      if (painted_m == 0) {
        EXPECT_NEAR(share(PointFit::kUnknown), 0.5, 0.12);
      }
    }
  }
}

TEST_F(SlabView, SeenThroughPointsAreViolations) {
  RgbdFrame frame = Render();
  PaintLeftHalf(frame, 0.6f);
  const FitReport fit = FitOf(frame);
  EXPECT_NEAR(fit.violated_share, 0.5, 0.06);
  EXPECT_NEAR(fit.inlier_share, 0.5, 0.06);
  EXPECT_LT(fit.hidden_share, 0.01);
}

TEST_F(SlabView, HolesAreUnknown) {
  RgbdFrame frame = Render();
  PaintLeftHalf(frame, 0);
  const FitReport fit = FitOf(frame);
  EXPECT_NEAR(fit.inlier_share, 0.5, 0.06);
  EXPECT_EQ(fit.violated_share, 0);
  EXPECT_EQ(fit.hidden_share, 0);
}

TEST_F(SlabView, PointsOutsideTheImageAreHidden) {
  X_CO_.translation().x() = 0.4 * 160 / 340;  // its center is on the image's right edge
  const FitReport fit = FitOf(Render());
  EXPECT_NEAR(fit.hidden_share, 0.5, 0.06);
  EXPECT_EQ(fit.violated_share, 0);
}

TEST_F(SlabView, OtherSlantIsAWrongNormal) {
  // A plane through the slab's face, tilted by 60 degrees. It is near the face along one line only.
  SyntheticDepth tilted(SmallCamera());
  const double a = std::numbers::pi / 3;
  tilted.AddPlane({std::sin(a), 0, -std::cos(a)}, {0, 0, 0.39});
  const VerifyFeatures f = FeaturesOf(tilted.frame(), X_CO_);
  EXPECT_LT(f[0], 0.01);
  EXPECT_GT(f[3], 0.02);
  EXPECT_GT(f[1], 0.3);
  EXPECT_GT(f[2], 0.3);
}

TEST_F(SlabView, QuickScoreIsInliersMinusViolations) {
  RgbdFrame frame = Render();
  const auto score = [&] {
    return QuickScore(BuildCloud(frame, std::nullopt, kKeepAll), model_, X_CO_);
  };
  EXPECT_GT(score(), 0.95);
  PaintLeftHalf(frame, 0.3f);
  EXPECT_NEAR(score(), 0.5, 0.1);
  PaintLeftHalf(frame, 0.6f);
  EXPECT_NEAR(score(), 0.0, 0.15);
  PaintLeftHalf(frame, 0);
  EXPECT_NEAR(score(), 0.5, 0.1);
}

TEST_F(SlabView, OnlyTheTruePoseExplainsTheScene) {
  const RgbdFrame frame = Render();
  const VerifyFeatures right = FeaturesOf(frame, X_CO_);
  EXPECT_NEAR(right[9], 1.0, 0.12);  // covers the expected pixels
  EXPECT_LT(right[5], 0.02);
  EXPECT_LT(right[6], 0.02);
  // Moved back by 6 and 11 mm, the face is near but unexplained.
  const VerifyFeatures near = FeaturesOf(frame, Translation({0, 0, 0.006}) * X_CO_);
  EXPECT_GT(near[5], 0.8);
  EXPECT_LT(near[9], 0.1);
  const VerifyFeatures far = FeaturesOf(frame, Translation({0, 0, 0.011}) * X_CO_);
  EXPECT_GT(far[6], 0.8);
}

TEST_F(SlabView, TwoMillimetresReduceTheTightInliers) {
  const RgbdFrame frame = Render();
  const VerifyFeatures f = FeaturesOf(frame, Translation({0, 0, 0.002}) * X_CO_);
  EXPECT_GT(f[0], 0.9);
  EXPECT_LT(f[4], 0.05);
  EXPECT_GT(FeaturesOf(frame, X_CO_)[4], 0.85);
}

TEST_F(SlabView, ExactSharesEqualTheSharesOfThePoints) {
  RgbdFrame frame = Render();
  PaintLeftHalf(frame, 0.3f);
  const VerifyFeatures hidden = FeaturesOf(frame, X_CO_);
  EXPECT_NEAR(hidden[kAgreeingFeature], hidden[0], 0.06);
  EXPECT_NEAR(hidden[13], hidden[1], 0.06);
  PaintLeftHalf(frame, 0.6f);
  const VerifyFeatures violated = FeaturesOf(frame, X_CO_);
  EXPECT_NEAR(violated[kViolatedFeature], violated[2], 0.06);
}

TEST_F(SlabView, OutlineDistinguishesAnObjectFromAWall) {
  EXPECT_EQ(FeaturesOf(Render(), X_CO_)[kContinuingFeature], 0);
  SyntheticDepth wall(SmallCamera());
  wall.AddPlane(-Eigen::Vector3d::UnitZ(), {0, 0, 0.39});
  EXPECT_GT(FeaturesOf(wall.frame(), X_CO_)[kContinuingFeature], 0.9);
}

TEST_F(SlabView, OnlyPixelsOfTheFaceAreMarked) {
  const RgbdFrame frame = Render();
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
  std::vector<uint8_t> marked(cloud.points_C.size());
  MarkExplained(cloud, model_, Translation({0, 0, 0.006}) * X_CO_, marked);
  EXPECT_LT(std::count(marked.begin(), marked.end(), 1),
            0.1 * static_cast<double>(cloud.foreground_pixels.size()));
  MarkExplained(cloud, model_, X_CO_, marked);
  for (size_t i = 0; i < marked.size(); ++i) EXPECT_EQ(marked[i], cloud.foreground.data()[i]);
}

TEST(EvidenceMargin, OddBoundedAndIncreasing) {
  EXPECT_EQ(EvidenceMargin(500, 500), 0);
  EXPECT_FLOAT_EQ(EvidenceMargin(900, 700), 0.5f);
  EXPECT_FLOAT_EQ(EvidenceMargin(700, 900), -0.5f);
  EXPECT_GT(EvidenceMargin(1e7, 0), 0.99f);
  EXPECT_LE(EvidenceMargin(1e7, 0), 1.0f);
}

TEST_F(SlabView, FeaturesAreFiniteEverywhere) {
  const RgbdFrame frame = Render();
  Rng rng(4);
  for (int i = 0; i < 200; ++i) {
    Pose X(rng.Rotation());
    X.translation() = Eigen::Vector3d(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
    for (const float f : FeaturesOf(frame, X, rng.Uniform(0, 50))) EXPECT_TRUE(std::isfinite(f));
  }
  EXPECT_FLOAT_EQ(FeaturesOf(frame, X_CO_, 7)[8], std::log(8.0f));
}

// Far from the camera noise is larger, and so are the bands.
TEST(MeasureFit, BandsGrowWithDistance) {
  const auto object = ObjectOf(BoxMesh({0.3, 0.3, 0.05}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*object);
  const Pose X_CO = Translation({0, 0, 1.5});
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(object->mesh_O, Translation({0, 0, 0.005}) * X_CO);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  EXPECT_GT(MeasureFit(cloud, model, X_CO).inlier_share, 0.9);  // 5 mm off, band 6.75 mm
}

// A known floor at the model's depth is no evidence. A floor seen below the model is evidence
// against it.
TEST(MeasureFit, FloorIsNoEvidenceForAnObjectOnIt) {
  const auto object = ObjectOf(BoxMesh({0.06, 0.06, 0.002}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*object);
  KnownBackground background;
  background.X_CB = Translation({0, 0, 0.6}) *
                    Pose(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BinMesh(background.bin), background.X_CB);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), background);
  const FitReport flat = MeasureFit(cloud, model, background.X_CB);
  EXPECT_EQ(flat.inlier_share, 0);
  EXPECT_LT(flat.violated_share, 0.05);
  const FitReport above = MeasureFit(cloud, model, background.X_CB * Translation({0, 0, 0.03}));
  EXPECT_GT(above.violated_share, 0.95);
}

TEST(Verifier, ScoreEqualsTheFormula) {
  Rng rng(9);
  Verifier v;
  const auto random = [&](int rows, int cols) {
    Eigen::MatrixXf m(rows, cols);
    for (float& x : m.reshaped()) x = static_cast<float>(rng.Normal());
    return m;
  };
  v.known.mean = random(kVerifyFeatures, 1);
  v.known.scale = random(kVerifyFeatures, 1).cwiseAbs().array() + 0.5f;
  v.known.w1 = random(24, kVerifyFeatures);
  v.known.b1 = random(24, 1);
  v.known.w2 = random(24, 1);
  v.known.b2 = 0.3f;
  v.unknown = v.known;
  v.unknown.b2 = -0.6f;
  v.calibrations[0] = {{{0.4f, -0.2f}, {0.7f, 0.1f}}};  // accurate, fast
  v.calibrations[2] = {{{0.9f, -0.3f}, {1, 0}}};
  VerifyFeatures f;
  for (float& x : f) x = static_cast<float>(rng.Normal());
  const Eigen::Map<const Eigen::VectorXf> x(f.data(), f.size());
  const Eigen::VectorXf hidden =
      (v.known.w1 * ((x - v.known.mean).cwiseQuotient(v.known.scale)) + v.known.b1).array().tanh();
  const double logit = hidden.dot(v.known.w2) + v.known.b2;
  EXPECT_NEAR(v.Score(f), 1 / (1 + std::exp(0.2 - 0.4 * logit)), 1e-5);
  EXPECT_NEAR(v.Score(f, CandidateMode::kFast), 1 / (1 + std::exp(-0.1 - 0.7 * logit)), 1e-5);
  EXPECT_NEAR(v.Score(f, CandidateMode::kAccurate, BackgroundKind::kNone),
              1 / (1 + std::exp(0.3 - 0.9 * (logit - 0.9))), 1e-5);
}

// Files that are older than a feature contain no weights for it.
TEST(VerifiersFrom, LaterFeaturesHaveNoWeight) {
  constexpr int kKnown = kWithoutOutline.features, kHidden = 5;
  Verifier narrow;
  narrow.known.mean = Eigen::VectorXf::LinSpaced(kKnown, -1, 1);
  narrow.known.scale = Eigen::VectorXf::Constant(kKnown, 0.7f);
  narrow.known.w1 = Eigen::MatrixXf::Constant(kHidden, kKnown, 0.1f);
  narrow.known.b1 = narrow.known.w2 = Eigen::VectorXf::LinSpaced(kHidden, 0.2f, 0.9f);
  narrow.unknown = narrow.known;
  const Verifier wide = VerifiersFrom(VerifierValues({narrow}), 1, {.features = kKnown}).front();
  VerifyFeatures features;
  features.fill(0.3f);
  const double score = wide.Score(features);
  features.back() = 0.9f;
  EXPECT_EQ(wide.Score(features), score);
  features[kKnown - 1] = 0.9f;
  EXPECT_NE(wide.Score(features), score);
}

}  // namespace
}  // namespace pickbed::tests
