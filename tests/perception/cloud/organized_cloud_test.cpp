#include "perception/cloud/organized_cloud.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/error.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

int BorderPixels(const OrganizedCloud& cloud, int border, const auto& visit) {
  int visited = 0;
  const int width = cloud.intrinsics.width(), height = cloud.intrinsics.height();
  for (int y = border; y < height - border; ++y) {
    for (int x = border; x < width - border; ++x, ++visited) visit(x, y, y * width + x);
  }
  return visited;
}

// A plane's inverse depth is linear in the pixel, so the fit must be exact at any slant.
TEST(BuildCloud, PlaneIsExact) {
  for (const double slant_deg : {0.0, 30.0, 50.0}) {
    const double a = slant_deg * std::numbers::pi / 180;
    const Eigen::Vector3d normal(std::sin(a), 0, -std::cos(a));
    SyntheticDepth scene(SmallCamera());
    scene.AddPlane(normal, {0, 0, 0.8});
    const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
    double worst_cos = 1, worst_off = 0;
    BorderPixels(cloud, 4, [&](int x, int y, int i) {
      worst_cos = std::min<double>(worst_cos, cloud.normals_C[i].dot(normal.cast<float>()));
      worst_off =
          std::max<double>(worst_off, std::abs(cloud.depth_m(x, y) - scene.frame().depth_m(x, y)));
    });
    EXPECT_GT(worst_cos, std::cos(0.5 * std::numbers::pi / 180)) << slant_deg;
    EXPECT_LT(worst_off, 2e-5) << slant_deg;
  }
}

TEST(BuildCloud, SphereNormalsPointOutwards) {
  const Eigen::Vector3d center(0.02, -0.01, 0.6);
  SyntheticDepth scene(SmallCamera());
  scene.AddSphere(center, 0.08);
  const OrganizedCloud cloud = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  int checked = 0;
  for (const int i : cloud.foreground_pixels) {
    const Eigen::Vector3d outward = (cloud.points_C[i].cast<double>() - center).normalized();
    if (outward.z() > -0.6) continue;  // the rim of the sphere
    const double cosine = cloud.normals_C[i].cast<double>().dot(outward);
    EXPECT_GT(cosine, std::cos(2.0 * std::numbers::pi / 180));
    ++checked;
  }
  EXPECT_GT(checked, 2000);
}

TEST(BuildCloud, SmoothingReducesNoise) {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane({0.2, 0.1, -1}, {0, 0, 0.9});
  Rng rng(7);
  const RgbdFrame noisy = WithNoise(scene.frame(), 0.001, rng);
  const OrganizedCloud cloud = BuildCloud(noisy, std::nullopt, kKeepAll);
  double before = 0, after = 0;
  BorderPixels(cloud, 4, [&](int x, int y, int) {
    before += std::pow(noisy.depth_m(x, y) - scene.frame().depth_m(x, y), 2);
    after += std::pow(cloud.depth_m(x, y) - scene.frame().depth_m(x, y), 2);
  });
  // A plane fitted to 25 readings reduces noise five times at its center. The gain is smaller where
  // noise makes a window beside the pixel fit better.
  EXPECT_GT(std::sqrt(before / after), 4.3);
  EXPECT_LT(std::sqrt(before / after), 5.2);
}

TEST(BuildCloud, DepthStepsStaySharp) {
  const CameraIntrinsics k = SmallCamera();
  RgbdFrame frame{k, {}, Image<float>(k.width(), k.height(), 0.80f)};
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 160; x < k.width(); ++x) frame.depth_m(x, y) = 0.85f;
  }
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
  EXPECT_NEAR(cloud.depth_m(159, 120), 0.80, 1e-5);
  EXPECT_NEAR(cloud.depth_m(160, 120), 0.85, 1e-5);
  EXPECT_LT(cloud.normals_C[120 * k.width() + 159].z(), -0.999);
}

TEST(BuildCloud, SingleHolesAreFilledAndLargeOnesStayUnknown) {
  const CameraIntrinsics k = SmallCamera();
  RgbdFrame frame{k, {}, Image<float>(k.width(), k.height(), 0.8f)};
  frame.depth_m(50, 60) = 0;
  for (int y = 100; y < 104; ++y) {
    for (int x = 100; x < 104; ++x) frame.depth_m(x, y) = 0;
  }
  frame.depth_m(200, 50) = std::nanf("");
  const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, kKeepAll);
  EXPECT_NEAR(cloud.depth_m(50, 60), 0.8, 1e-6);
  EXPECT_NEAR(cloud.depth_m(200, 50), 0.8, 1e-6);
  for (int y = 100; y < 104; ++y) {
    for (int x = 100; x < 104; ++x) {
      const int i = y * k.width() + x;
      EXPECT_EQ(cloud.depth_m(x, y), 0);
      EXPECT_EQ(cloud.foreground(x, y), 0);
      EXPECT_TRUE(cloud.points_C[i].isZero(0));
      EXPECT_TRUE(cloud.normals_C[i].isZero(0));
    }
  }
}

TEST(FillSinglePixelHoles, FillsWithAnExistingValue) {
  Image<float> depth(3, 3, 0.5f);
  depth(2, 0) = depth(2, 1) = depth(2, 2) = 0.9f;
  depth(1, 1) = 0;
  EXPECT_EQ(FillSinglePixelHoles(depth)(1, 1), 0.5f);
  EXPECT_EQ(FillSinglePixelHoles(depth)(0, 0), 0.5f);
}

// Camera 0.85 m above a bin. Only the pixels of an object in the bin are foreground.
class InBin : public ::testing::Test {
 protected:
  InBin() : scene_(SmallCamera()) {
    background_.X_CB = LookAt({0, -0.12, 0.85}, {0, 0, 0}, {0, 0, 1}).inverse();
    scene_.AddMesh(BinMesh(background_.bin), background_.X_CB);
  }
  KnownBackground background_;
  SyntheticDepth scene_;
};

TEST_F(InBin, EmptyBinIsAllBackground) {
  EXPECT_TRUE(BuildCloud(scene_.frame(), background_).foreground_pixels.empty());
  Rng rng(3);
  const OrganizedCloud noisy = BuildCloud(WithNoise(scene_.frame(), 0.001, rng), background_);
  EXPECT_LT(noisy.foreground_pixels.size(), 5u);  // the margin is four sigma: 3e-5 of 60,000 pixels
}

TEST_F(InBin, ObjectIsForegroundAlsoAboveTheRim) {
  const Image<float> empty = scene_.frame().depth_m;
  const Pose X_BO = Translation({0.03, 0.02, 0.10});
  scene_.AddMesh(BoxMesh({0.04, 0.04, 0.2}, Eigen::Vector3d::Zero()), background_.X_CB * X_BO);
  const OrganizedCloud cloud = BuildCloud(scene_.frame(), background_);
  int object_pixels = 0, wrong = 0;
  for (size_t i = 0; i < empty.size(); ++i) {
    const bool is_object = scene_.frame().depth_m.data()[i] < empty.data()[i] - 0.006f;
    object_pixels += is_object;
    wrong += is_object != (cloud.foreground.data()[i] != 0);
  }
  EXPECT_GT(object_pixels, 500);
  EXPECT_LT(wrong, object_pixels / 50);  // pixels within the margin above the floor
  EXPECT_TRUE(std::is_sorted(cloud.foreground_pixels.begin(), cloud.foreground_pixels.end()));
}

TEST_F(InBin, ObjectsOutsideTheBinAreBackground) {
  const Pose X_BO = Translation({0.24, 0, 0.05});
  scene_.AddMesh(BoxMesh({0.03, 0.03, 0.1}, Eigen::Vector3d::Zero()), background_.X_CB * X_BO);
  EXPECT_TRUE(BuildCloud(scene_.frame(), background_).foreground_pixels.empty());
}

TEST(BuildCloud, UnknownTableIsFoundAndRemoved) {
  const Pose X_WC = LookAt({0, -0.3, 0.6}, {0, 0, 0}, {0, 0, 1});
  const Pose X_CW = X_WC.inverse();
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane(X_CW.linear() * Eigen::Vector3d::UnitZ(), X_CW.translation());
  scene.AddMesh(BoxMesh({0.05, 0.08, 0.06}, {0, 0, 0.03}), X_CW);
  Rng rng(5);
  const OrganizedCloud cloud =
      BuildCloud(WithNoise(scene.frame(), 0.0005, rng), std::nullopt, CloudOptions{});
  EXPECT_GT(cloud.foreground_pixels.size(), 1000u);
  for (const int i : cloud.foreground_pixels) {
    const Eigen::Vector3d p_W = X_WC * cloud.points_C[i].cast<double>();
    EXPECT_GT(p_W.z(), 0.0005);
    EXPECT_LT(p_W.cwiseAbs().maxCoeff(), 0.07);
  }
}

TEST(BuildCloud, KeepsAllPixelsIfRequested) {
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(BoxMesh({0.1, 0.1, 0.02}, {0, 0, 0}), Translation({0, 0, 0.5}));
  const size_t seen =
      std::count_if(scene.frame().depth_m.pixels().begin(), scene.frame().depth_m.pixels().end(),
                    [](float z) { return z > 0; });
  EXPECT_EQ(BuildCloud(scene.frame(), std::nullopt, kKeepAll).foreground_pixels.size(), seen);
}

TEST(BuildCloud, SameFrameSameBytes) {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane({0, 0.3, -1}, {0, 0, 0.8});
  scene.AddSphere({0, 0, 0.6}, 0.05);
  Rng rng(1);
  const RgbdFrame frame = WithNoise(scene.frame(), 0.001, rng);
  const OrganizedCloud a = BuildCloud(frame, std::nullopt), b = BuildCloud(frame, std::nullopt);
  EXPECT_EQ(a.depth_m, b.depth_m);
  EXPECT_EQ(a.foreground, b.foreground);
  EXPECT_EQ(a.normals_C, b.normals_C);
}

TEST(BuildCloud, WrongSizesAreReportedSeparately) {
  const CameraIntrinsics k = SmallCamera();
  const RgbdFrame frame{k, {}, Image<float>(100, 240)};
  EXPECT_THAT([&] { BuildCloud(frame, std::nullopt); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("100x240")));
  const RgbdFrame painted{k, Image<Rgb8>(64, 48), Image<float>(k.width(), k.height())};
  EXPECT_THAT([&] { BuildCloud(painted, std::nullopt); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr(fmt::format(
                  "color image is 64x48 and depth image {}x{}", k.width(), k.height()))));
  const RgbdFrame right{k, {}, Image<float>(k.width(), k.height())};
  EXPECT_THAT([&] { BuildCloud(right, std::nullopt, {.normal_window_px = 4}); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("normal_window_px is 4")));
}

}  // namespace
}  // namespace pickbed::tests
