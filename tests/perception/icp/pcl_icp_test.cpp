#include "perception/icp/pcl_icp.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>

#include "perception/verify/pose_features.h"
#include "tests/support/cloud_options.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

class BracketPclIcp : public ::testing::Test {
 protected:
  BracketPclIcp() : object_(ObjectOf(BracketMesh())), model_(MakeModelPoints(*object_)) {
    SyntheticDepth scene(SmallCamera());
    scene.AddMesh(object_->mesh_O, BracketPose());
    cloud_ = BuildCloud(scene.frame(), std::nullopt, kKeepAll);
  }
  std::shared_ptr<const ObjectModel> object_;
  ModelPoints model_;
  OrganizedCloud cloud_;
};

TEST_F(BracketPclIcp, CorrectsASmallError) {
  const PclIcp icp(cloud_);
  Rng rng(1);
  for (int i = 0; i < 10; ++i) {
    const Pose start = Perturbed(BracketPose(), rng.UnitVector(), 3, 0.002 * rng.UnitVector());
    const IcpResult result = icp.Refine(model_, start);
    const PoseGap gap = GapBetween(result.X_CO, BracketPose());
    EXPECT_LT(gap.angle_deg, 1.0) << i;
    EXPECT_LT(gap.shift_m, 0.001) << i;
    EXPECT_EQ(result.status, IcpStatus::kRefined) << i;
    EXPECT_GT(result.iterations, 0) << i;
    EXPECT_LE(result.iterations, PclIcpOptions().iterations) << i;
    const FitReport fit = MeasureFit(cloud_, model_, result.X_CO);
    EXPECT_GE(fit.inlier_share, MeasureFit(cloud_, model_, start).inlier_share - 0.05) << i;
    EXPECT_LT(fit.residual_m, 0.0006) << i;
    EXPECT_LT(result.rmse_m, 0.0006) << i;
    EXPECT_GT(result.inlier_fraction, 0.6) << i;
  }
}

double Quality(const FitReport& fit) {
  return fit.inlier_share * (1 - std::pow(fit.residual_m / 0.003, 2)) - fit.violated_share;
}

// For a pose far from the truth, the nearest points belong to another side of the object. Whatever
// ICP does then, the fit must not become worse.
TEST_F(BracketPclIcp, NeverLowersTheFit) {
  const PclIcp icp(cloud_);
  Rng rng(2);
  int undone = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose start = Perturbed(BracketPose(), rng.UnitVector(), rng.Uniform(0, 40),
                                 rng.Uniform(0, 0.01) * rng.UnitVector());
    const IcpResult result = icp.Refine(model_, start);
    const FitReport before = MeasureFit(cloud_, model_, start);
    const FitReport after = MeasureFit(cloud_, model_, result.X_CO);
    EXPECT_NEAR(result.start_agreement, Quality(before), 1e-12) << i;
    EXPECT_NEAR(result.agreement, Quality(after), 1e-12) << i;
    if (result.status == IcpStatus::kRefined) {
      EXPECT_GE(result.agreement, result.start_agreement) << i;
    } else {
      EXPECT_EQ(result.X_CO.matrix(), start.matrix());
      EXPECT_EQ(result.iterations, 0) << i;
      ++undone;
    }
  }
  EXPECT_GT(undone, 0);
  EXPECT_LT(undone, 40);
}

TEST_F(BracketPclIcp, NoCorrespondencesLeaveThePoseUnchanged) {
  const PclIcp icp(cloud_);
  const Pose far_away = Translation({0.1, 0.1, 0.9});
  const IcpResult result = icp.Refine(model_, far_away);
  EXPECT_EQ(result.status, IcpStatus::kTooFewCorrespondences);
  EXPECT_EQ(result.inlier_fraction, 0);
  EXPECT_EQ(result.X_CO.matrix(), far_away.matrix());

  const CameraIntrinsics k = SmallCamera();
  const OrganizedCloud empty =
      BuildCloud({k, {}, Image<float>(k.width(), k.height())}, std::nullopt);
  EXPECT_EQ(PclIcp(empty).Refine(model_, far_away).status, IcpStatus::kTooFewCorrespondences);
}

// A range scan of about 400 points, about 4 mm apart.
struct Scan {
  std::vector<Eigen::Vector3f> points, normals;
};

// Normals from the principal axes of the nearest points, oriented towards the origin.
std::vector<Eigen::Vector3f> NormalsOf(const std::vector<Eigen::Vector3f>& points) {
  constexpr size_t kNeighbors = 10;
  std::vector<Eigen::Vector3f> normals;
  for (const Eigen::Vector3f& p : points) {
    std::vector<Eigen::Vector3f> near = points;
    std::nth_element(near.begin(), near.begin() + kNeighbors, near.end(),
                     [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
                       return (a - p).squaredNorm() < (b - p).squaredNorm();
                     });
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (size_t i = 0; i < kNeighbors; ++i) mean += near[i] / kNeighbors;
    Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
    for (size_t i = 0; i < kNeighbors; ++i) {
      spread += (near[i] - mean) * (near[i] - mean).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes(spread);
    const Eigen::Vector3f n = axes.eigenvectors().col(0);
    normals.push_back(n.dot(p) > 0 ? Eigen::Vector3f(-n) : n);
  }
  return normals;
}

Scan ReadAsciiPcd(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line) && line.rfind("DATA ascii", 0) != 0) {
  }
  Scan scan;
  Eigen::Vector3f p;
  while (std::getline(in, line)) {
    if (std::sscanf(line.c_str(), "%f %f %f", &p.x(), &p.y(), &p.z()) == 3 && p.allFinite()) {
      scan.points.push_back(p);
    }
  }
  scan.normals = NormalsOf(scan.points);
  return scan;
}

// The scan at 0.6 m from a camera whose pixel spacing equals the point spacing.
OrganizedCloud AsCloud(const Scan& scan) {
  const CameraIntrinsics k(64, 64, 130, 130, 32, 8);
  OrganizedCloud cloud;
  cloud.intrinsics = k;
  cloud.depth_m = Image<float>(k.width(), k.height());
  cloud.foreground = Image<uint8_t>(k.width(), k.height());
  cloud.points_C.assign(cloud.depth_m.size(), Eigen::Vector3f::Zero());
  cloud.normals_C = cloud.points_C;
  for (size_t i = 0; i < scan.points.size(); ++i) {
    const Eigen::Vector3f p = scan.points[i] + Eigen::Vector3f(0, 0, 0.6f);
    const Eigen::Vector2d pixel = Project(k, p.cast<double>());
    const int x = static_cast<int>(std::lround(pixel.x()));
    const int y = static_cast<int>(std::lround(pixel.y()));
    cloud.depth_m(x, y) = p.z();
    cloud.foreground(x, y) = 1;
    cloud.points_C[y * k.width() + x] = p;
    cloud.normals_C[y * k.width() + x] = scan.normals[i];
  }
  for (int i = 0; i < k.width() * k.height(); ++i) {
    if (cloud.foreground.data()[i]) cloud.foreground_pixels.push_back(i);
  }
  return cloud;
}

ModelPoints AsModel(const Scan& scan) {
  ModelPoints model;
  model.points_O = scan.points;
  model.normals_O = scan.normals;
  model.directions_O = {-Eigen::Vector3f::UnitZ()};
  model.visible.resize(1);
  model.diameter_m = 0.2f;
  for (size_t i = 0; i < scan.points.size(); ++i) {
    model.visible[0].push_back(static_cast<uint16_t>(i));
    model.center_O += scan.points[i] / static_cast<float>(scan.points.size());
  }
  return model;
}

// Points on one plane that faces the camera can slide along it and turn on it, so the equations of
// a step have no solution.
TEST(PclIcp, SlidingPointsLeaveThePoseUnchanged) {
  constexpr float kSurface_m = 0.6f, kStart_m = 0.601f;
  Scan plane;
  for (int x = -10; x <= 10; ++x) {
    for (int y = 2; y <= 20; ++y) {
      plane.points.emplace_back(0.004f * x, 0.004f * y, 0.0f);
      plane.normals.emplace_back(0.0f, 0.0f, -1.0f);
    }
  }
  const OrganizedCloud cloud = AsCloud(plane);
  ASSERT_FLOAT_EQ(cloud.points_C[cloud.foreground_pixels[0]].z(), kSurface_m);
  const Pose start = Translation({0, 0, kStart_m});
  const PclIcpOptions options{.max_correspondence_distance_m = 0.01, .target_stride = 1};
  const IcpResult result = PclIcp(cloud, options).Refine(AsModel(plane), start);
  EXPECT_EQ(result.status, IcpStatus::kStepTooLarge);
  EXPECT_EQ(result.X_CO.matrix(), start.matrix());
}

TEST(PclIcp, RegistersTwoRealScans) {
  const std::filesystem::path folder = std::filesystem::path(PICKBED_TEST_DATA) / "registration";
  if (!std::filesystem::exists(folder / "bun0.pcd")) {
    GTEST_SKIP() << "no " << folder << "; BracketPclIcp tests the same on a synthetic scene";
  }
  const Scan bun0 = ReadAsciiPcd(folder / "bun0.pcd");
  const OrganizedCloud cloud = AsCloud(ReadAsciiPcd(folder / "bun4.pcd"));
  const ModelPoints model = AsModel(bun0);
  ASSERT_GT(bun0.points.size(), 300u);
  Pose truth = Pose::Identity();
  truth.matrix().topRows<3>() << 0.825336, 0, -0.564642, 0.037267,  //
      0, 1, 0, 0,                                                   //
      0.564642, 0, 0.825336, 0.038325 + 0.6;
  // The scans overlap only partly, so the maximum correspondence distance has to decrease.
  const PclIcpOptions coarse{
      .max_correspondence_distance_m = 0.012, .iterations = 40, .target_stride = 1};
  const PclIcpOptions fine{
      .max_correspondence_distance_m = 0.004, .iterations = 40, .target_stride = 1};
  const Eigen::Vector3d center = model.center_O.cast<double>();
  Rng rng(1);
  for (int i = 0; i < 10; ++i) {
    const Pose rotation(Eigen::AngleAxisd(3 * std::numbers::pi / 180, rng.UnitVector()));
    const Pose start =
        truth * Translation(center + 0.005 * rng.UnitVector()) * rotation * Translation(-center);
    const Pose coarse_X_CO = PclIcp(cloud, coarse).Refine(model, start).X_CO;
    const Pose X_CO = PclIcp(cloud, fine).Refine(model, coarse_X_CO).X_CO;
    double sum = 0;
    for (const Eigen::Vector3f& p : bun0.points) {
      sum += (X_CO * p.cast<double>() - truth * p.cast<double>()).norm();
    }
    // A start at the ground truth ends 1.6 mm off: half of the point spacing.
    EXPECT_LT(sum / static_cast<double>(bun0.points.size()), 0.002) << i;
  }
}

}  // namespace
}  // namespace pickbed::tests
