#include "eval/frames/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/camera/depth_points.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {
namespace {

// Diameter of an object in the image up to which the estimators are reliable, px.
constexpr double kUsefulDiameter_px = 40;
constexpr double kVisibleDepth_m = 1e-3;  // edges of a box are drawn from here on

bool Holds(const Bounds& box, const Eigen::Vector3d& p) {
  return (p.array() >= box.min.array()).all() && (p.array() <= box.max.array()).all();
}

Bounds WorkingVolume(const RgbdFrame& frame, const ObjectSet& objects) {
  constexpr double kNearShare = 0.05, kDiametersBehind = 4;
  double largest_m = 0;
  for (const auto& object : objects) largest_m = std::max(largest_m, object->diameter_m);
  const CameraIntrinsics& k = frame.intrinsics;
  const double focal_px = std::sqrt(k.fx() * k.fy());
  std::vector<float> readings;
  for (const float z : frame.depth_m.pixels()) {
    if (z > 0) readings.push_back(z);
  }
  double nearest_m = 0;
  if (!readings.empty()) {
    const auto nth = readings.begin() + static_cast<long>(kNearShare * (readings.size() - 1));
    std::nth_element(readings.begin(), nth, readings.end());
    nearest_m = *nth;
  }
  const double near_m = focal_px * largest_m / std::max(k.width(), k.height());
  const double far_m =
      std::max(focal_px * largest_m / kUsefulDiameter_px, nearest_m + kDiametersBehind * largest_m);
  constexpr double kWide_m = 1e3;
  return {Eigen::Vector3d(-kWide_m, -kWide_m, near_m), Eigen::Vector3d(kWide_m, kWide_m, far_m)};
}

Image<uint8_t> MaskOf(const std::string& file, const RgbdFrame& frame) {
  const Image<Rgb8> mask = ReadPng(file);
  CheckInput(
      mask.width() == frame.depth_m.width() && mask.height() == frame.depth_m.height(),
      fmt::format("{}: the mask is {}x{} px but the image {}x{} px; draw it on this image", file,
                  mask.width(), mask.height(), frame.depth_m.width(), frame.depth_m.height()));
  Image<uint8_t> pixels(mask.width(), mask.height());
  for (size_t i = 0; i < pixels.size(); ++i) pixels.data()[i] = mask.data()[i] != Rgb8{};
  return pixels;
}

bool IsInMask(const Image<uint8_t>& mask, const CameraIntrinsics& camera, const TriangleMesh& mesh,
              const Pose& X_CO) {
  constexpr size_t kSamples = 500;
  const size_t stride = mesh.vertices.size() / kSamples + 1;
  int inside = 0, count = 0;
  for (size_t i = 0; i < mesh.vertices.size(); i += stride) {
    const Eigen::Vector3d p_C = X_CO * mesh.vertices[i];
    ++count;
    if (!(p_C.z() > 0)) continue;
    const Eigen::Vector2d pixel = Project(camera, p_C);
    const double x = std::round(pixel.x()), y = std::round(pixel.y());
    if (!(x >= 0 && y >= 0 && x < mask.width() && y < mask.height())) continue;
    inside += mask(static_cast<int>(x), static_cast<int>(y)) != 0;
  }
  return 2 * inside >= count;
}

}  // namespace

std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> ImageRegion::BoxLines(
    const CameraIntrinsics& camera) const {
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> lines;
  if (!box || is_depth_range) return lines;
  const auto corner_C = [&](int index) {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = (index >> axis & 1) != 0 ? box->max[axis] : box->min[axis];
    }
    return Eigen::Vector3d(X_CR * p);
  };
  for (int a = 0; a < 8; ++a) {
    for (int axis = 0; axis < 3; ++axis) {
      const int b = a | 1 << axis;
      if (b == a) continue;
      Eigen::Vector3d from = corner_C(a), to = corner_C(b);
      if (from.z() < to.z()) std::swap(from, to);
      if (from.z() <= kVisibleDepth_m) continue;
      if (to.z() < kVisibleDepth_m) {
        to = from + (from.z() - kVisibleDepth_m) / (from.z() - to.z()) * (to - from);
      }
      lines.emplace_back(Project(camera, from), Project(camera, to));
    }
  }
  return lines;
}

ImageRegion MakeRegion(const RegionSpec& spec, const RgbdFrame& frame,
                       const std::optional<Pose>& X_CW, const ObjectSet& objects) {
  ImageRegion region;
  if (!spec.mask.empty()) {
    region.pixels = MaskOf(spec.mask, frame);
    return region;
  }
  if (spec.automatic) {
    region.box = WorkingVolume(frame, objects);
    region.is_depth_range = true;
  } else {
    region.box = Bounds{spec.min_m, spec.max_m};
    if (spec.frame == "world") {
      CheckInput(X_CW.has_value(),
                 "the region is in the world frame, but the pose of the camera is not known; give "
                 "the box in the camera frame");
      region.X_CR = *X_CW;
    }
  }
  const Pose X_RC = region.X_CR.inverse();
  region.pixels = Image<uint8_t>(frame.depth_m.width(), frame.depth_m.height());
  ForEachDepthPoint(frame.intrinsics, frame.depth_m, [&](int u, int v, const Eigen::Vector3d& p_C) {
    region.pixels(u, v) = Holds(*region.box, X_RC * p_C);
  });
  return region;
}

bool HasReadingIn(const ImageRegion& region, const RgbdFrame& frame) {
  for (size_t i = 0; i < frame.depth_m.size(); ++i) {
    if (frame.depth_m.data()[i] > 0 && region.pixels.data()[i] != 0) return true;
  }
  return false;
}

void RequireReadingsIn(const ImageRegion& region, const RgbdFrame& frame, const std::string& name) {
  if (HasReadingIn(region, frame)) return;
  float nearest_m = std::numeric_limits<float>::infinity(), farthest_m = 0;
  for (size_t i = 0; i < frame.depth_m.size(); ++i) {
    const float z = frame.depth_m.data()[i];
    if (!(z > 0)) continue;
    nearest_m = std::min(nearest_m, z);
    farthest_m = std::max(farthest_m, z);
  }
  throw InputError(fmt::format(
      "region '{}': no depth reading of the image is in it; {}", name,
      farthest_m > 0 ? fmt::format("readings are from {:.3g} to {:.3g} m", nearest_m, farthest_m)
                     : "the image has no reading"));
}

Image<uint8_t> RegionInPicture(const ImageRegion& region, const CameraIntrinsics& camera,
                               const CameraIntrinsics& picture) {
  Image<uint8_t> pixels(picture.width(), picture.height());
  for (int y = 0; y < pixels.height(); ++y) {
    for (int x = 0; x < pixels.width(); ++x) {
      const Eigen::Vector2d at = Project(camera, BackProject(picture, x, y, 1));
      const double u = std::round(at.x()), v = std::round(at.y());
      if (!(u >= 0 && v >= 0 && u < region.pixels.width() && v < region.pixels.height())) continue;
      pixels(x, y) = region.pixels(static_cast<int>(u), static_cast<int>(v));
    }
  }
  return pixels;
}

void KeepPosesIn(const ImageRegion& region, const CameraIntrinsics& camera,
                 const ObjectSet& objects, std::vector<PoseHypothesis>& poses) {
  const Pose X_RC = region.X_CR.inverse();
  std::erase_if(poses, [&](const PoseHypothesis& pose) {
    const TriangleMesh& mesh_O = objects[pose.object]->mesh_O;
    if (!region.box) return !IsInMask(region.pixels, camera, mesh_O, pose.X_CO);
    return !Holds(*region.box, X_RC * (pose.X_CO * MeshBounds(mesh_O).center()));
  });
}

}  // namespace pickbed::eval
