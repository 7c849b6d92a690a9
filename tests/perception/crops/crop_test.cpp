#include "perception/crops/crop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/crops/crop_augment.h"
#include "perception/crops/crop_views.h"
#include "perception/model/pose_distance.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A plane z = z0 + slope x seen by a camera of 200 x 200 px.
RgbdFrame PlaneFrame(double z0_m, double slope) {
  CameraIntrinsics camera{200, 200, 300, 300, 99.5, 99.5};
  RgbdFrame frame{camera, Image<Rgb8>(200, 200, {10, 20, 30}), Image<float>(200, 200)};
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      frame.depth_m(x, y) =
          static_cast<float>(z0_m / (1 - slope * (x - camera.cx()) / camera.fx()));
    }
  }
  return frame;
}

double Relative(const CropSet& crops, int x, int y) {
  return crops.depth[y * kCropPixels + x] / kCropDepthUnit;
}

TEST(Crop, DepthIsRelativeToTheCenterInSides) {
  CropSet crops;
  AppendCrop(PlaneFrame(1.0, 0.5), {{0, 0, 1}, 0.2}, nullptr, crops);
  // A quarter of the side right of the center, the plane is deeper by about the slope times that
  // distance. The line of sight meets it slightly farther out.
  EXPECT_NEAR(Relative(crops, 48, 32), 0.5 * 0.258, 0.015);
  EXPECT_NEAR(Relative(crops, 16, 32), -0.5 * 0.242, 0.015);
  EXPECT_EQ(crops.color[0], (Rgb8{10, 20, 30}));
  EXPECT_TRUE(crops.masks.empty());
}

// A surface twice as far away in a crop twice as large gives the same crop.
TEST(Crop, CropIsIndependentOfScale) {
  CropSet crops;
  AppendCrop(PlaneFrame(1.0, 0.4), {{0, 0, 1}, 0.2}, nullptr, crops);
  AppendCrop(PlaneFrame(2.0, 0.4), {{0, 0, 2}, 0.4}, nullptr, crops);
  for (int p = 0; p < kCropArea; ++p) ASSERT_NEAR(crops.depth[p], crops.depth[kCropArea + p], 2);
}

TEST(Crop, MissingReadingsAreFar) {
  RgbdFrame frame = PlaneFrame(1.0, 0);
  frame.depth_m(100, 100) = 0;
  CropSet crops;
  AppendCrop(frame, {{0, 0, 1}, 1.0}, nullptr, crops);  // wider than the image
  EXPECT_EQ(Relative(crops, 0, 0), 1);
  EXPECT_NEAR(Relative(crops, 20, 20), 0, 1e-3);
  frame.depth_m = Image<float>(200, 200);
  CropSet empty;
  AppendCrop(frame, {{0, 0, 1}, 0.2}, nullptr, empty);
  for (const int16_t depth : empty.depth) ASSERT_EQ(depth, kCropDepthUnit);
}

TEST(Crop, CenterBehindTheCameraIsRefused) {
  CropSet crops;
  EXPECT_THAT(ErrorOf([&] {
                AppendCrop(PlaneFrame(1, 0), {{0, 0, -1}, 0.2}, nullptr, crops);
              }),
              HasSubstr("a crop of 0.2 m at a depth of -1 m"));
}

TEST(CropViews, IcosahedronLevelsAreNestedAndBalanced) {
  const std::vector<Eigen::Vector3d> coarse = IcosahedronDirections(2);
  const std::vector<Eigen::Vector3d> fine = IcosahedronDirections(3);
  EXPECT_EQ(IcosahedronDirections(0).size(), 12u);
  EXPECT_EQ(coarse.size(), 162u);
  EXPECT_EQ(fine.size(), 642u);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < fine.size(); ++i) {
    EXPECT_NEAR(fine[i].norm(), 1, 1e-12);
    if (i < coarse.size()) {
      EXPECT_EQ(fine[i], coarse[i]);
    }
    sum += fine[i];
  }
  EXPECT_LT(sum.norm(), 1e-9);
}

// The camera looks along the negative direction. Near directions give near orientations, also at
// the pole.
TEST(CropViews, OrientationFollowsTheDirection) {
  Rng rng(3);
  for (int i = 0; i < 50; ++i) {
    Eigen::Vector3d direction_O = rng.UnitVector();
    direction_O.z() = std::abs(direction_O.z());
    const Eigen::Matrix3d R_CO = RotationOfView(direction_O, rng.Uniform(-1, 1));
    EXPECT_LT((R_CO * direction_O + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(R_CO.determinant(), 1, 1e-9);
  }
  const double step_rad = 0.01;
  for (const double azimuth : {0.0, 1.0, 2.0, 3.0}) {
    const Eigen::Vector3d tilted(std::sin(step_rad) * std::cos(azimuth),
                                 std::sin(step_rad) * std::sin(azimuth), std::cos(step_rad));
    EXPECT_NEAR(
        RotationAngleRad(RotationOfView(Eigen::Vector3d::UnitZ(), 0), RotationOfView(tilted, 0)),
        step_rad, 1e-6);
  }
}

TEST(CropViews, TestViewsDifferFromAllOtherViews) {
  CropViewOptions options;
  options.template_level = 2;
  options.train_level = 3;
  Rotations others = TemplateRotations(options);
  const Rotations further = TrainingRotations(options);
  others.insert(others.end(), further.begin(), further.end());
  Rng rng(1);
  const Rotations tests = TestRotations(200, options, rng);
  ASSERT_EQ(tests.size(), 200u);
  for (const Eigen::Matrix3d& test : tests) {
    EXPECT_LE(test(2, 2), 0);  // from above
    for (const Eigen::Matrix3d& other : others) {
      ASSERT_GT(RotationAngleRad(test, other), options.apart_rad);
    }
  }
}

TEST(RotationDistance, MinimumOverAllSymmetries) {
  SymmetrySet prism;  // rotations by 90 degrees about z and by 180 about x
  const ContinuousSymmetry x{Eigen::Vector3d::UnitX()}, z{Eigen::Vector3d::UnitZ()};
  for (int i = 1; i < 4; ++i) {
    prism.discrete_O.push_back(TurnAbout(z, i * std::numbers::pi / 2));
  }
  for (int i = 0; i < 4; ++i) {
    prism.discrete_O.push_back(TurnAbout(z, i * std::numbers::pi / 2) *
                               TurnAbout(x, std::numbers::pi));
  }
  SymmetrySet can;
  can.continuous_O = {z};
  can.discrete_O = {TurnAbout(x, std::numbers::pi)};
  Rng rng(5);
  for (const SymmetrySet& symmetries : {SymmetrySet{}, prism, can}) {
    const RotationDistance distance(symmetries);
    const std::vector<Pose> all = SymmetryTransforms(symmetries, 3600);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Matrix3d a = rng.Rotation().toRotationMatrix();
      const Eigen::Matrix3d b = rng.Rotation().toRotationMatrix();
      double smallest = 10;
      for (const Pose& S : all) smallest = std::min(smallest, RotationAngleRad(a, b * S.linear()));
      EXPECT_NEAR(distance(a, b), smallest, 1e-3);
      EXPECT_NEAR(distance(a, a * all[i % all.size()].linear()), 0, 1e-6);
    }
  }
}

TEST(RotationDistance, ZeroForABall) {
  SymmetrySet ball;
  ball.continuous_O = {{Eigen::Vector3d::UnitX()}, {Eigen::Vector3d::UnitZ()}};
  Rng rng(5);
  EXPECT_EQ(
      RotationDistance(ball)(rng.Rotation().toRotationMatrix(), rng.Rotation().toRotationMatrix()),
      0);
}

class CropAugment : public testing::Test {
 protected:
  CropAugment() {
    CropViewOptions views;
    views.template_level = 0;
    RayCastViews source({ObjectOf(BracketMesh())}, 0);
    pool_ = RenderCrops(source, ObjectId{0}, TemplateRotations(views), views, 1).crops;
    RayCastViews others({ObjectOf(BoxMesh({0.05, 0.05, 0.05}, Eigen::Vector3d::Zero()))}, 0);
    blockers_ = RenderCrops(others, ObjectId{0}, TemplateRotations(views), views, 1).crops;
  }
  CropSet pool_, blockers_;
};

TEST_F(CropAugment, NoAugmentationKeepsTheCrop) {
  CropAugmentOptions none;
  none.background_share = none.occluded_share = none.shift_depth = 0;
  none.shift_px = 0;
  Rng rng(1);
  CropSet out;
  AppendAugmented(pool_, 2, pool_, none, rng, out);
  EXPECT_TRUE(std::equal(out.depth.begin(), out.depth.end(), pool_.depth_of(2).begin()));
}

TEST_F(CropAugment, BackgroundKeepsTheObject) {
  CropAugmentOptions background;
  background.background_share = 1;
  background.occluded_share = background.shift_depth = 0;
  background.shift_px = 0;
  Rng rng(1);
  CropSet out;
  AppendAugmented(pool_, 0, pool_, background, rng, out);
  int behind = 0;
  for (int p = 0; p < kCropArea; ++p) {
    if (pool_.masks[p]) {
      ASSERT_EQ(out.depth[p], pool_.depth[p]);
    } else if (out.depth[p] < kCropDepthUnit) {
      ++behind;
    }
  }
  EXPECT_GT(behind, kCropArea / 10);
}

TEST_F(CropAugment, OcclusionStaysWithinTheLimit) {
  CropAugmentOptions occluded;
  occluded.background_share = occluded.shift_depth = 0;
  occluded.shift_px = 0;
  occluded.occluded_share = 1;
  occluded.occluded_max = 0.3;
  double max_hidden = 0;
  for (int i = 0; i < 60; ++i) {
    Rng rng(i);
    CropSet out;
    const size_t row = i % pool_.size();
    AppendAugmented(pool_, row, blockers_, occluded, rng, out);
    int visible = 0, hidden = 0;
    for (int p = 0; p < kCropArea; ++p) {
      if (!pool_.masks[row * kCropArea + p]) continue;
      ++visible;
      hidden += out.depth[p] != pool_.depth_of(row)[p];
    }
    max_hidden = std::max(max_hidden, static_cast<double>(hidden) / visible);
  }
  EXPECT_LE(max_hidden, 0.3);
  EXPECT_GT(max_hidden, 0.15);
}

TEST_F(CropAugment, EmptyBlockersHideNothing) {
  CropAugmentOptions occluded;
  occluded.background_share = occluded.shift_depth = 0;
  occluded.shift_px = 0;
  occluded.occluded_share = 1;
  std::fill(blockers_.masks.begin(), blockers_.masks.end(), 0);
  Rng rng(1);
  CropSet out;
  AppendAugmented(pool_, 2, blockers_, occluded, rng, out);
  EXPECT_TRUE(std::equal(out.depth.begin(), out.depth.end(), pool_.depth_of(2).begin()));
}

}  // namespace
}  // namespace pickbed::tests
