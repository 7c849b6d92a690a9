// Agreement of poses with images without readings or with one pixel, of objects without volume, and
// of poses at or behind the camera.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/verify/color_consistency.h"
#include "perception/verify/depth_evidence.h"
#include "perception/verify/edge_support.h"
#include "perception/verify/image_domain.h"
#include "perception/verify/non_maximum_suppression.h"
#include "perception/verify/physical_consistency.h"
#include "perception/verify/pose_features.h"
#include "perception/verify/pose_support.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/cloud_options.h"
#include "tests/support/degenerate_depth.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

const Pose kInFront = Translation({0, 0, 0.4});

ModelPoints Bracket() { return MakeModelPoints(*ObjectOf(BracketMesh()), 300, 60); }

// A cloud of one depth and one color.
OrganizedCloud FlatCloud(int width, int height, float depth_m) {
  RgbdFrame frame;
  frame.intrinsics = {width, height, 300, 300, 0.5 * (width - 1), 0.5 * (height - 1)};
  frame.depth_m = Image<float>(width, height, depth_m);
  frame.color = Image<Rgb8>(width, height, {90, 90, 90});
  return BuildCloud(frame, std::nullopt, kKeepAll);
}

PoseHypothesis HypothesisAt(const Pose& X_CO, double score) {
  PoseHypothesis hypothesis;
  hypothesis.X_CO = X_CO;
  hypothesis.score = score;
  return hypothesis;
}

TEST(DegeneratePoseFit, WithoutReadingsNothingAgreesOrContradicts) {
  const ModelPoints model = Bracket();
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(320, 240)}) {
    const OrganizedCloud cloud = FlatCloud(width, height, 0);
    for (const Pose& X_CO : {kInFront, Pose::Identity(), Translation({0, 0, -0.4}),
                             Translation({0, 0, 1e30}), Translation({1e30, 0, 1})}) {
      EXPECT_EQ(QuickScore(cloud, model, X_CO), 0);
      const FitReport fit = MeasureFit(cloud, model, X_CO);
      EXPECT_EQ(fit.inlier_share, 0);
      EXPECT_EQ(fit.violated_share, 0);
      EXPECT_EQ(fit.residual_m, 0);
      for (const JudgedPoint& judged : JudgePoints(cloud, model, X_CO)) {
        EXPECT_TRUE(judged.fit == PointFit::kUnknown || judged.fit == PointFit::kHidden);
      }
      std::vector<uint8_t> explained(cloud.points_C.size());
      MarkExplained(cloud, model, X_CO, explained);
      EXPECT_THAT(explained, testing::Each(0));
    }
    EXPECT_EQ(MeasureFit(cloud, model, Translation({0, 0, -0.4})).hidden_share, 1);
  }
  EXPECT_EQ(MeasureFit(FlatCloud(320, 240, 0), model, kInFront).hidden_share, 0);
}

TEST(DegeneratePoseFit, NoPointsGiveNoScore) {
  const OrganizedCloud cloud = FlatCloud(320, 240, 0.4f);
  EXPECT_EQ(QuickScore(cloud, Bracket(), kInFront, 0.008, 0), 0);
  VerifyBands bands;
  bands.max_points = 0;
  EXPECT_EQ(MeasureFit(cloud, Bracket(), kInFront, bands).inlier_share, 0);
  EXPECT_TRUE(JudgePoints(cloud, Bracket(), kInFront, bands).empty());
}

TEST(DegeneratePoseFit, MarginIsWithinItsRange) {
  EXPECT_EQ(EvidenceMargin(0, 0), 0);
  for (const double nats : {1e-300, 1.0, 200.0, 1e9, 1e300}) {
    EXPECT_GE(EvidenceMargin(nats, 0), 0);
    EXPECT_LE(EvidenceMargin(nats, 0), 1);
    EXPECT_EQ(EvidenceMargin(0, nats), -EvidenceMargin(nats, 0));
  }
}

TEST(DegenerateEvidence, CountsAreConsistentForEveryMesh) {
  EvidenceScratch scratch;
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const auto object = ObjectOf(test.mesh);
    const DepthEvidenceOf evidence_of(*object);
    const Bounds bounds = MeshBounds(test.mesh);
    const Pose X_CO = Translation(Vector3d(0, 0, 0.4) - bounds.center());
    for (const float depth_m : {0.0f, 0.4f}) {
      for (const auto& [width, height] : {std::pair(1, 1), std::pair(320, 240)}) {
        PoseSupportMeasure measure;
        const OrganizedCloud cloud = FlatCloud(width, height, depth_m);
        const DepthEvidence e = evidence_of(cloud, X_CO, scratch, 1000, &measure);
        EXPECT_TRUE(std::isfinite(e.log_ratio)) << test.name;
        const double judged = e.agreeing + e.hidden + e.violated + e.wrong_normal;
        EXPECT_LE(judged, e.covered) << test.name;
        if (!test.has_area || depth_m == 0) {
          EXPECT_EQ(judged, 0) << test.name;
          EXPECT_EQ(e.log_ratio, 0) << test.name;
        }
        EXPECT_TRUE(test.has_area || e.covered == 0) << test.name;
        const PoseSupport support = measure.Finish();
        EXPECT_TRUE(std::isfinite(support.weakest) && support.weakest >= 0) << test.name;
        EXPECT_GE(support.second_weakest, support.weakest) << test.name;
        EXPECT_GE(support.outline_seen, 0) << test.name;
        EXPECT_LE(support.outline_seen, 1) << test.name;
        EXPECT_GE(support.coplanar, 0) << test.name;
        EXPECT_LE(support.coplanar, kMaxCoplanar) << test.name;
      }
    }
  }
}

TEST(DegenerateSupport, FewOrEqualReadingsHoldNothing) {
  const Vector3f p_C(0, 0, 1), normal_C(0, 0, -1);
  for (const float radius_m : {0.1f, 0.0f}) {
    for (const int readings : {0, 1, 100}) {
      PoseSupportMeasure measure;
      measure.Begin(p_C, radius_m, 0.001f);
      for (int i = 0; i < readings; ++i) {
        measure.AddCovered();
        measure.AddAgreeing(p_C, normal_C);
        measure.AddOutline(p_C, Vector3f::Zero(), i % 2 == 0);
      }
      const PoseSupport support = measure.Finish();
      EXPECT_EQ(support.weakest, 0) << readings;
      EXPECT_NEAR(support.second_weakest, 0, 1e-3) << readings;
      EXPECT_EQ(support.coplanar, 0) << readings;
      EXPECT_EQ(support.outline_seen, readings == 0 ? 0 : readings == 1 ? 1 : 0.5);
    }
  }
  PoseSupportMeasure others;
  others.Begin(p_C, 0.1f, 0.001f);
  others.AddOther(p_C);
  others.AddOutline(p_C, Vector3f::UnitX(), true);
  EXPECT_EQ(others.Finish().coplanar, 0);  // no pixel is covered
  EXPECT_EQ(others.Finish().outline_seen, 0);
}

TEST(DegenerateEdgeSupport, FlatImagesHaveNoGradient) {
  const ModelPoints model = Bracket();
  const OrganizedCloud grey = FlatCloud(320, 240, 0);
  const EdgeSupport seen = MeasureEdgeSupport(grey, model, kInFront);
  EXPECT_GT(seen.visible, 100);
  EXPECT_NEAR(seen.mean, 0, 1e-4);
  OrganizedCloud colorless = grey;
  colorless.edges = {};
  EXPECT_EQ(MeasureEdgeSupport(colorless, model, kInFront).visible, 0);
  ModelPoints smooth = model;
  smooth.edges.clear();
  EXPECT_EQ(MeasureEdgeSupport(grey, smooth, kInFront).visible, 0);
  EXPECT_EQ(MeasureEdgeSupport(grey, smooth, kInFront).mean, 0);
}

// Pixels of these points are far outside the image, up to 1e41 px.
TEST(DegenerateEdgeSupport, PointsBesideTheImageAreNotVisible) {
  const OrganizedCloud grey = FlatCloud(320, 240, 0);
  ModelPoints model;
  model.edges = {{{0, 0, 0}, {0, 0, 1}, {0, 1, -1}, {0, -1, -1}}};
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double x_m : {1.0, 1e9, 1e30, infinity, -1.0, -1e9, -1e30, -infinity}) {
    for (const double z_m : {1.0, 300 / 4294967296.0, 1e-30, 0.0, -1.0}) {
      for (const Pose& X_CO : {Translation({x_m, 0, z_m}), Translation({0, x_m, z_m})}) {
        EXPECT_EQ(MeasureEdgeSupport(grey, model, X_CO).visible, 0) << x_m << " " << z_m;
      }
    }
  }
}

TEST(DegenerateDomain, AnImageWithoutReadingsIsInTheDomain) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(320, 240)}) {
    OrganizedCloud cloud = FlatCloud(width, height, 0);
    const ImageDomain domain = DomainOf(cloud);
    EXPECT_EQ(domain.hole_share, 0);
    EXPECT_EQ(domain.error_at_1m_m, 0);
    EXPECT_EQ(domain.tilt_rad, 0);
    EXPECT_TRUE(DomainWarnings(domain).empty());
    EXPECT_EQ(LogitPenalty(domain, kMinRoomDiameter_px, 0), 0);
    // A steep plane without a reading on it says nothing about the camera.
    cloud.planes = {{Vector3f(1, 0, 0), -0.5f}};
    cloud.background = BackgroundKind::kFitted;
    EXPECT_EQ(DomainOf(cloud).tilt_rad, 0);
  }
}

TEST(DegenerateDomain, PenaltyIsFiniteForAnyDiameter) {
  const double largest = LogitPenalty({}, 0, 1);
  EXPECT_TRUE(std::isfinite(largest));
  for (const double diameter_px :
       {0.0, 1e-300, 1.0, 1e300, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_GE(LogitPenalty({}, diameter_px, 0), 0) << diameter_px;
    EXPECT_LE(LogitPenalty({}, diameter_px, 1), largest) << diameter_px;
  }
}

TEST(DegenerateDomain, OutsideShareIsOneBehindTheCamera) {
  const ModelPoints model = Bracket();
  const CameraIntrinsics one_pixel(1, 1, 300, 300, 0, 0);
  for (const CameraIntrinsics& k : {one_pixel, SmallCamera()}) {
    EXPECT_EQ(OutsideShare(k, model, Translation({0, 0, -0.4})), 1);
    EXPECT_EQ(OutsideShare(k, model, Translation({1e30, 0, 0.4})), 1);
    EXPECT_EQ(OutsideShare(k, model, Translation({0, 0, 1e30})), 0);  // all in one pixel
    const double inside = OutsideShare(k, model, Translation(-model.center_O.cast<double>()));
    EXPECT_GE(inside, 0);
    EXPECT_LE(inside, 1);
  }
  EXPECT_GT(OutsideShare(one_pixel, model, kInFront), 0.9);
  EXPECT_EQ(OutsideShare(SmallCamera(), model, kInFront), 0);
}

TEST(DegenerateSuppression, EqualHypothesesAreOne) {
  const std::vector<ModelPoints> models{Bracket()};
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BracketMesh(), kInFront);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  EXPECT_TRUE(SuppressNonMaxima(cloud, models, {}).empty());
  EXPECT_TRUE(SuppressNonMaxima(cloud, {}, {}).empty());
  const std::vector<PoseHypothesis> same(50, HypothesisAt(kInFront, 0.5));
  const auto kept = SuppressNonMaxima(cloud, models, same);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].suppressed_X_CO.size(), 49u);
  EXPECT_TRUE(SuppressNonMaxima(cloud, models, same, {}, std::vector<int>{0}).empty());
  for (const Pose& X_CO :
       {Pose::Identity(), Translation({0, 0, -0.4}), Translation({0, 0, 1e30})}) {
    EXPECT_TRUE(SuppressNonMaxima(cloud, models, {HypothesisAt(X_CO, 1)}).empty());
  }
  const OrganizedCloud empty = FlatCloud(320, 240, 0), one_pixel = FlatCloud(1, 1, 0);
  EXPECT_TRUE(SuppressNonMaxima(empty, models, same).empty());
  EXPECT_TRUE(SuppressNonMaxima(one_pixel, models, same).empty());
}

TEST(DegenerateContact, FlatObjectsPenetrateNothing) {
  const ModelPoints bracket = Bracket();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (!test.has_area || Diameter(test.mesh) > 10) continue;
    const ModelPoints model = MakeModelPoints(*ObjectOf(test.mesh), 100, 20);
    const double itself = PenetrationDepth(model, kInFront, model, kInFront);
    EXPECT_GE(itself, 0) << test.name;
    EXPECT_LT(itself, 0.1 * model.diameter_m) << test.name;  // its points are on its surface
    const Pose X_CO = kInFront * Translation(-model.center_O.cast<double>());
    const double depth_m = PenetrationDepth(model, X_CO, bracket, kInFront);
    EXPECT_TRUE(depth_m >= 0 && depth_m <= bracket.radius_m + model.radius_m) << test.name;
    EXPECT_EQ(depth_m, PenetrationDepth(bracket, kInFront, model, X_CO)) << test.name;
    EXPECT_EQ(PenetrationDepth(model, X_CO, bracket, Translation({1e30, 0, 0})), 0) << test.name;
    EXPECT_EQ(PenetrationDepth(model, Translation({nan, 0, 0}), bracket, kInFront), 0) << test.name;
  }
}

TEST(DegenerateContact, PointsAreOverTheFloorByTheirHeight) {
  ModelPoints point;
  point.points_O = {{0, 0, 0}};
  OrganizedCloud cloud;
  EXPECT_FALSE(MeasureContainment(cloud, point, kInFront).has_floor);
  cloud.planes = {{Vector3f(0, 0, -1), -0.5f}};
  const Containment above = MeasureContainment(cloud, point, kInFront);
  EXPECT_TRUE(above.has_floor);
  EXPECT_NEAR(above.height_m, 0.1f, 1e-6f);
  EXPECT_EQ(above.outside_m, 0);
  const Containment below = MeasureContainment(cloud, point, Translation({0, 0, 0.7}));
  EXPECT_NEAR(below.height_m, -0.2f, 1e-6f);
  EXPECT_NEAR(below.outside_m, 0.2f, 1e-6f);
}

TEST(DegenerateColors, NothingIsOddWithoutColorReadingsOrInstances) {
  const std::vector<ModelPoints> models{Bracket()};
  const std::vector<PoseHypothesis> accepted(8, HypothesisAt(kInFront, 0.9));
  OrganizedCloud grey = FlatCloud(320, 240, 0.4f);
  OrganizedCloud black = grey, colorless = grey;
  black.color = Image<Rgb8>(320, 240);
  colorless.color = {};
  OrganizedCloud no_reading = FlatCloud(320, 240, 0), one_pixel = FlatCloud(1, 1, 0.4f);
  for (const OrganizedCloud* cloud : {&grey, &black, &colorless, &no_reading, &one_pixel}) {
    for (const size_t count : {0, 1, 8}) {
      const CommonColors colors(*cloud, models, std::span(accepted).first(count));
      PoseHypothesis hypothesis = accepted[0];
      EXPECT_FALSE(colors.LowerIfOdd(hypothesis));
      EXPECT_EQ(hypothesis.score, 0.9);
    }
  }
}

}  // namespace
}  // namespace pickbed::tests
