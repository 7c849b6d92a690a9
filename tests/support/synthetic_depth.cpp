#include "tests/support/synthetic_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scenes/geometry/mesh_query.h"

namespace pickbed::tests {
namespace {

Eigen::Vector3d Ray(const CameraIntrinsics& k, int x, int y) { return BackProject(k, x, y, 1.0); }

// Columns and rows that the projection of a mesh can cover.
struct Box {
  int x0, y0, x1, y1;
};

Box PixelsOf(const CameraIntrinsics& k, const TriangleMesh& mesh_C) {
  constexpr double kFarOff = 1e6;
  Eigen::Vector2d low(kFarOff, kFarOff), high = -low;
  for (const Eigen::Vector3d& p : mesh_C.vertices) {
    if (p.z() <= 0) return {0, 0, k.width(), k.height()};
    low = low.cwiseMin(Project(k, p));
    high = high.cwiseMax(Project(k, p));
  }
  const auto cut = [](double value, int limit) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(limit)));
  };
  return {cut(std::floor(low.x()), k.width()), cut(std::floor(low.y()), k.height()),
          cut(std::ceil(high.x()) + 1, k.width()), cut(std::ceil(high.y()) + 1, k.height())};
}

}  // namespace

SyntheticDepth::SyntheticDepth(const CameraIntrinsics& intrinsics) {
  frame_.intrinsics = intrinsics;
  frame_.depth_m = Image<float>(intrinsics.width(), intrinsics.height());
}

void SyntheticDepth::Offer(int x, int y, double depth_m) {
  float& seen = frame_.depth_m(x, y);
  if (depth_m > 0 && (seen == 0 || depth_m < seen)) seen = static_cast<float>(depth_m);
}

void SyntheticDepth::AddPlane(const Eigen::Vector3d& normal_C, const Eigen::Vector3d& point_C) {
  const CameraIntrinsics& k = frame_.intrinsics;
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      Offer(x, y, normal_C.dot(point_C) / normal_C.dot(Ray(k, x, y)));
    }
  }
}

void SyntheticDepth::AddSphere(const Eigen::Vector3d& center_C, double radius_m) {
  const CameraIntrinsics& k = frame_.intrinsics;
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      // The nearer root of |z * ray - center| = radius.
      const Eigen::Vector3d ray = Ray(k, x, y);
      const double a = ray.squaredNorm(), b = ray.dot(center_C);
      const double root = b * b - a * (center_C.squaredNorm() - radius_m * radius_m);
      if (root >= 0) Offer(x, y, (b - std::sqrt(root)) / a);
    }
  }
}

void SyntheticDepth::AddMesh(const TriangleMesh& mesh_O, const Pose& X_CO) {
  const CameraIntrinsics& k = frame_.intrinsics;
  const TriangleMesh mesh_C = Transformed(mesh_O, X_CO);
  const MeshQuery query(mesh_C);
  const Box box = PixelsOf(k, mesh_C);
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const auto hit = query.Raycast(Eigen::Vector3d::Zero(), Ray(k, x, y).normalized(), 0,
                                     std::numeric_limits<double>::max());
      if (hit) Offer(x, y, hit->point.z());
    }
  }
}

CameraIntrinsics SmallCamera() { return {320, 240, 340, 340, 159.5, 119.5}; }

RgbdFrame WithNoise(RgbdFrame frame, double sigma_m, Rng& rng) {
  for (float& z : frame.depth_m.pixels()) {
    if (z > 0) z += static_cast<float>(sigma_m * z * z * rng.Normal());
  }
  return frame;
}

TriangleMesh BoxMesh(const Eigen::Vector3d& size_m, const Eigen::Vector3d& center_O) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    mesh.vertices.push_back(center_O + 0.5 * sign.cwiseProduct(size_m));
  }
  // Corners of the faces -x +x -y +y -z +z, counter-clockwise from outside.
  constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : kFaces) {
    mesh.triangles.emplace_back(f[0], f[1], f[2]);
    mesh.triangles.emplace_back(f[0], f[2], f[3]);
  }
  return mesh;
}

TriangleMesh BracketMesh() {
  TriangleMesh mesh = BoxMesh({0.060, 0.024, 0.010}, {0, 0, -0.015});
  Append(BoxMesh({0.010, 0.024, 0.030}, {-0.025, 0, 0.005}), mesh);
  Append(BoxMesh({0.014, 0.010, 0.012}, {0.017, 0.007, -0.004}), mesh);
  return mesh;
}

Pose BracketPose() {
  Pose X = Translation({0.01, -0.01, 0.40});
  X.linear() = (Eigen::AngleAxisd(2.4, Eigen::Vector3d::UnitX()) *
                Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()))
                   .toRotationMatrix();
  return X;
}

std::shared_ptr<const ObjectModel> ObjectOf(const TriangleMesh& mesh,
                                            const SymmetrySet& symmetries) {
  auto object = std::make_shared<ObjectModel>();
  object->name = "test part";
  object->mesh_O = mesh;
  object->symmetries_O = symmetries;
  object->diameter_m = Diameter(mesh);
  object->mesh_hash = MeshHash(mesh);
  return object;
}

Pose Perturbed(const Pose& X_CO, const Eigen::Vector3d& axis, double angle_deg,
               const Eigen::Vector3d& shift_m) {
  Pose X = X_CO;
  X.linear() =
      Eigen::AngleAxisd(angle_deg * std::numbers::pi / 180, axis.normalized()) * X_CO.linear();
  X.translation() += shift_m;
  return X;
}

PoseGap GapBetween(const Pose& X_CA, const Pose& X_CB) {
  return {RotationAngleRad(X_CA.linear(), X_CB.linear()) * 180 / std::numbers::pi,
          (X_CA.translation() - X_CB.translation()).norm()};
}

}  // namespace pickbed::tests
