#include "perception/features/patch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/error.h"
#include "tests/support/analytic_clouds.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

constexpr int kCenter = kPatchPixels / 2;

double Value(const PatchSet& set, size_t patch, int channel, int row, int col) {
  return set.patch(patch)[channel * kPatchArea + row * kPatchPixels + col] / 127.0;
}

// Position of a grid point in the plane z = 0 of P, m.
double GridCoordinate(int index, double side_m) {
  return (index + 0.5) / kPatchPixels * side_m - 0.5 * side_m;
}

TEST(PatchSide, SideIsOnTheGridNearTheRequest) {
  for (double diameter_m = 0.01; diameter_m < 1; diameter_m *= 1.07) {
    const double side_m = PatchSide(diameter_m, 0.8);
    const double steps = 2 * std::log2(side_m / 1e-3);
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
    EXPECT_LE(std::abs(std::log2(side_m / (0.8 * diameter_m))), 0.2501) << diameter_m;
  }
  EXPECT_EQ(PatchSide(0.100, 0.8), PatchSide(0.101, 0.8));
  EXPECT_THROW(PatchSide(0, 0.8), InputError);
}

TEST(PatchFrame, OriginIsThePointAndZIsTheRay) {
  const Eigen::Vector3d point(0.1, -0.2, 0.9);
  for (const double angle : {0.0, 0.7, 3.0, 6.0}) {
    const Pose X_CP = PatchFrame(point, angle);
    EXPECT_TRUE(X_CP.translation().isApprox(point));
    EXPECT_TRUE(X_CP.linear().col(2).isApprox(point.normalized(), 1e-12));
    EXPECT_TRUE((X_CP.linear().transpose() * X_CP.linear()).isIdentity(1e-12));
    EXPECT_NEAR(X_CP.linear().determinant(), 1, 1e-12);
  }
}

TEST(PatchFrame, AngleRotatesAboutTheRay) {
  const Eigen::Vector3d point(-0.1, 0.05, 0.7);
  const Pose X_PQ = PatchFrame(point, 0.4).inverse() * PatchFrame(point, 1.5);
  EXPECT_TRUE(X_PQ.linear().isApprox(
      Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()).toRotationMatrix(), 1e-12));
}

TEST(CutPatches, FrontalPlaneIsFlatWithNormalTowardsTheCamera) {
  const OrganizedCloud cloud = PlaneCloud(0.8, Eigen::Vector3d(0, 0, -1));
  const int pixel = CenterPixel(cloud);
  const PatchSet set = CutPatches(cloud, std::vector{pixel}, std::vector{0.3}, {0.08});
  for (const int row : {0, 7, kCenter, 31}) {
    for (const int col : {0, 13, kCenter, 31}) {
      // The ray of the pixel next to the optical axis tilts the patch by less than a milliradian.
      EXPECT_NEAR(Value(set, 0, 0, row, col), 0, 0.01);
      EXPECT_NEAR(Value(set, 0, 3, row, col), -1, 0.01);
    }
  }
}

TEST(CutPatches, TiltedPlaneHasTheDepthOfItsEquation) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.2, -1).normalized();
  const OrganizedCloud cloud = PlaneCloud(0.8, normal);
  const int pixel = CenterPixel(cloud) + 40;
  const double side_m = 0.08;
  const PatchSet set = CutPatches(cloud, std::vector{pixel}, std::vector{1.1}, {side_m});
  const Eigen::Matrix3d R_PC = set.X_CP[0].linear().transpose();
  const Eigen::Vector3d normal_P = R_PC * normal;
  const double camera_m = set.X_CP[0].translation().norm();
  for (int row = 0; row < kPatchPixels; row += 3) {
    for (int col = 0; col < kPatchPixels; col += 3) {
      // The camera at (0, 0, -camera_m) of P looks through the grid point at the plane n . p = 0.
      const Eigen::Vector3d grid(GridCoordinate(col, side_m), GridCoordinate(row, side_m), 0);
      const Eigen::Vector3d eye(0, 0, -camera_m);
      const double t = -normal_P.dot(eye) / normal_P.dot(grid - eye);
      const double depth_m = (eye + t * (grid - eye)).z();
      // Tolerance: half a pixel of 1.2 mm on a slope of 0.5, and half a step of 1/127.
      EXPECT_NEAR(Value(set, 0, 0, row, col), depth_m / (0.5 * side_m), 0.02) << row << " " << col;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(Value(set, 0, 1 + axis, row, col), normal_P[axis], 0.005);
      }
    }
  }
}

TEST(CutPatches, SphereHasAnalyticDepthAndNormals) {
  const double radius_m = 0.03, side_m = 0.08;
  const OrganizedCloud cloud = SphereCloud(0.8, radius_m);
  const PatchSet set =
      CutPatches(cloud, std::vector{CenterPixel(cloud)}, std::vector{0.0}, {side_m});
  for (int row = 0; row < kPatchPixels; ++row) {
    for (int col = 0; col < kPatchPixels; ++col) {
      const double x = GridCoordinate(col, side_m), y = GridCoordinate(row, side_m);
      const double r = std::hypot(x, y);
      if (r > radius_m + 0.003) {
        EXPECT_EQ(Value(set, 0, 0, row, col), 1.0) << "there is nothing beside the sphere";
        EXPECT_EQ(Value(set, 0, 3, row, col), 0.0);
      } else if (r < 0.7 * radius_m) {
        const double depth_m = radius_m - std::sqrt(radius_m * radius_m - r * r);
        EXPECT_NEAR(Value(set, 0, 0, row, col), depth_m / (0.5 * side_m), 0.04);
        // Perspective moves the surface point by up to 4 %; a pixel is 1.2 mm.
        EXPECT_NEAR(Value(set, 0, 1, row, col), x / radius_m, 0.06);
        EXPECT_NEAR(Value(set, 0, 2, row, col), y / radius_m, 0.06);
      }
    }
  }
}

TEST(CutPatches, QuarterRotationOfTheFrameRotatesTheImage) {
  const OrganizedCloud cloud = PlaneCloud(0.8, Eigen::Vector3d(0.4, 0.1, -1).normalized());
  const int pixel = CenterPixel(cloud);
  const double quarter = 0.5 * std::numbers::pi;
  const PatchSet set =
      CutPatches(cloud, std::vector{pixel, pixel}, std::vector{0.0, quarter}, {0.08});
  // x of the rotated frame is y of the first, y of the rotated frame is -x of the first.
  for (int row = 0; row < kPatchPixels; ++row) {
    for (int col = 0; col < kPatchPixels; ++col) {
      const int first_row = col, first_col = kPatchPixels - 1 - row;
      EXPECT_NEAR(Value(set, 1, 0, row, col), Value(set, 0, 0, first_row, first_col), 0.02);
      EXPECT_NEAR(Value(set, 1, 1, row, col), Value(set, 0, 2, first_row, first_col), 0.01);
      EXPECT_NEAR(Value(set, 1, 2, row, col), -Value(set, 0, 1, first_row, first_col), 0.01);
    }
  }
}

TEST(CutPatches, PatchIsIndependentOfDistance) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, 0.2, -1).normalized();
  const OrganizedCloud near = PlaneCloud(0.6, normal), far = PlaneCloud(1.2, normal);
  const PatchSet a = CutPatches(near, std::vector{CenterPixel(near)}, std::vector{0.5}, {0.06});
  const PatchSet b = CutPatches(far, std::vector{CenterPixel(far)}, std::vector{0.5}, {0.06});
  for (int i = 0; i < kPatchValues; ++i) {
    // Tolerance: a pixel of 1.8 mm at 1.2 m on a slope of one half, and weaker perspective.
    EXPECT_NEAR(a.values[i], b.values[i], 8) << i;
  }
}

TEST(CutPatches, PixelsOutsideTheImageAndBackgroundAreFar) {
  OrganizedCloud cloud = PlaneCloud(0.8, Eigen::Vector3d(0, 0, -1));
  const int corner = 5 * cloud.intrinsics.width() + 5;
  const PatchSet cut = CutPatches(cloud, std::vector{corner}, std::vector{0.0}, {0.08});
  EXPECT_EQ(Value(cut, 0, 0, 0, 0), 1.0);
  // The other corner sees the plane, which is slanted against the ray to the image's corner.
  const double half_m = 0.04;
  const Pose X_CP = cut.X_CP[0];
  const Eigen::Vector3d grid_C = X_CP * Eigen::Vector3d(half_m, half_m, 0);
  const Eigen::Vector3d hit_C = grid_C * (0.8 / grid_C.z());
  EXPECT_NEAR(Value(cut, 0, 0, 31, 31), (X_CP.inverse() * hit_C).z() / half_m, 0.05);
  cloud.foreground = Image<uint8_t>(cloud.intrinsics.width(), cloud.intrinsics.height(), 0);
  const PatchSet none = CutPatches(cloud, std::vector{corner}, std::vector{0.0}, {0.08});
  EXPECT_EQ(Value(none, 0, 0, 31, 31), 1.0);
  EXPECT_EQ(Value(none, 0, 3, 31, 31), 0.0);
}

// Red increases to the right of the image and green downwards, by 2.2 per pixel.
Rgb8 Paint(const CameraIntrinsics& k, double x, double y) {
  const auto byte = [](double v) { return static_cast<uint8_t>(std::clamp(v, 0.0, 255.0)); };
  return {byte(128 + 2.2 * (x - k.cx())), byte(128 + 2.2 * (y - k.cy())), 40};
}

OrganizedCloud PaintedPlane() {
  OrganizedCloud cloud = PlaneCloud(0.8, Eigen::Vector3d(0, 0, -1));
  const CameraIntrinsics& k = cloud.intrinsics;
  cloud.color = Image<Rgb8>(k.width(), k.height());
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) cloud.color(x, y) = Paint(k, x, y);
  }
  return cloud;
}

TEST(ColorPatches, ColorsMatchThePixelsAtAnyAngle) {
  const OrganizedCloud cloud = PaintedPlane();
  const double side_m = 0.08;
  const int pixel = CenterPixel(cloud);
  const std::vector<double> angles{0.0, 0.9, 0.5 * std::numbers::pi, 4.0};
  const PatchSet set = CutPatches(cloud, std::vector<int>(angles.size(), pixel), angles,
                                  {side_m, PatchChannels::kDepthColor});
  for (size_t i = 0; i < angles.size(); ++i) {
    for (int cell = 0; cell < kPatchArea; ++cell) {
      const int row = cell / kPatchPixels, col = cell % kPatchPixels;
      const Eigen::Vector3d grid_P(GridCoordinate(col, side_m), GridCoordinate(row, side_m), 0);
      const Eigen::Vector2d at = Project(cloud.intrinsics, set.X_CP[i] * grid_P);
      const Rgb8 expected = Paint(cloud.intrinsics, at.x(), at.y());
      const Rgb8 seen = PatchColorAt(set.patch(i), cell);
      // Tolerance: half a pixel, truncated bytes and a step of the stored value.
      ASSERT_NEAR(seen.r, expected.r, 3.1) << angles[i] << " " << row << " " << col;
      ASSERT_NEAR(seen.g, expected.g, 3.1) << angles[i] << " " << row << " " << col;
      ASSERT_NEAR(seen.b, expected.b, 1);
    }
  }
}

TEST(ColorPatches, ValuesSpanTheRangeAndDepthIsUnchanged) {
  OrganizedCloud cloud = PaintedPlane();
  std::ranges::fill(cloud.color.pixels(), Rgb8{0, 255, 128});
  const std::vector<int> pixel{CenterPixel(cloud)};
  const std::vector<double> angle{0.3};
  const PatchSet color = CutPatches(cloud, pixel, angle, {0.08, PatchChannels::kDepthColor});
  const PatchSet normals = CutPatches(cloud, pixel, angle, {0.08});
  for (int i = 0; i < kPatchArea; ++i) {
    EXPECT_EQ(color.values[i], normals.values[i]);
    EXPECT_EQ(color.values[i + kPatchArea], -127);
    EXPECT_EQ(color.values[i + 2 * kPatchArea], 127);
    EXPECT_NEAR(color.values[i + 3 * kPatchArea], 0, 1);
  }
  cloud.color = {};
  EXPECT_EQ(CutPatches(cloud, pixel, angle, {0.08}).values, normals.values);
}

TEST(ColorPatches, BackgroundAndOutsideAreNeutral) {
  OrganizedCloud cloud = PaintedPlane();
  const std::vector<int> corner{5 * cloud.intrinsics.width() + 5};
  const std::vector<double> angle{0.0};
  const PatchForm form{0.08, PatchChannels::kDepthColor};
  const PatchSet cut = CutPatches(cloud, corner, angle, form);
  EXPECT_TRUE(IsUnknownAt(cut.patch(0), 0));
  EXPECT_FALSE(IsUnknownAt(cut.patch(0), kPatchArea - 1));
  cloud.foreground = Image<uint8_t>(cloud.intrinsics.width(), cloud.intrinsics.height(), 0);
  const PatchSet none = CutPatches(cloud, corner, angle, form);
  for (int i = 0; i < kPatchArea; ++i) {
    EXPECT_EQ(none.values[i], 127);
    for (int c = 1; c < kPatchChannels; ++c) EXPECT_EQ(none.values[i + c * kPatchArea], 0);
  }
}

TEST(ColorPatches, CloudWithoutColorIsRefused) {
  OrganizedCloud cloud = PaintedPlane();
  RequireChannels(cloud, PatchChannels::kDepthColor);
  cloud.color = {};
  EXPECT_THAT(ErrorOf([&] { RequireChannels(cloud, PatchChannels::kDepthColor); }),
              testing::HasSubstr("no color image"));
  RequireChannels(cloud, PatchChannels::kDepthNormals);
}

}  // namespace
}  // namespace pickbed::tests
