#include "perception/completion/traced_solid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

constexpr int kBlock_px = 8;
constexpr int kMaxSteps = 96;
// A ray ends this share of its distance before the surface.
constexpr float kHitShare = 5e-5f;

// Rays that march at once, because distances of many points cost less per point.
struct Ray {
  Eigen::Vector3f direction_O;  // unit
  float along_m = 0;            // distance from the camera
  float end_m = 0;              // where it leaves the bounding sphere
  int index = 0;                // of its pixel or block
};

// Marches all rays until they hit or leave. A ray with a spread is a cone: it stops where its
// radius touches the solid. `on_hit` is called for each ray that does not leave.
template <typename OnHit>
void March(const SignedDistances& distances_m, const Eigen::Vector3f& eye_O, std::vector<Ray>& rays,
           float spread, const OnHit& on_hit) {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> values;
  for (int step = 0; step < kMaxSteps && !rays.empty(); ++step) {
    points.resize(rays.size());
    values.resize(rays.size());
    for (size_t i = 0; i < rays.size(); ++i) {
      points[i] = eye_O + rays[i].along_m * rays[i].direction_O;
    }
    distances_m(points, values);
    size_t kept = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      Ray& ray = rays[i];
      const float radius_m = std::max(spread, kHitShare) * ray.along_m;
      if (values[i] <= radius_m) {
        on_hit(ray);
        continue;
      }
      // A cone keeps its radius away from the surface.
      ray.along_m +=
          spread > 0 ? (values[i] - radius_m) / (1 + spread) + 0.2f * radius_m : values[i];
      if (ray.along_m < ray.end_m) rays[kept++] = ray;
    }
    rays.resize(kept);
  }
  for (const Ray& ray : rays) on_hit(ray);
}

}  // namespace

Image<float> TracedSolid::Depth(const CameraIntrinsics& k, const Pose& X_CO) const {
  Image<float> depth_m(k.width(), k.height(), 0);
  const Pose X_OC = X_CO.inverse();
  const Eigen::Matrix3f R_OC = X_OC.linear().cast<float>();
  const Eigen::Vector3f eye_O = X_OC.translation().cast<float>();
  const Eigen::Vector3f center_C = (X_CO * box_O_.center().cast<double>()).cast<float>();
  const float radius_m = 0.5f * box_O_.diagonal().norm();

  const auto ray_to = [&](double u, double v, int index) {
    const Eigen::Vector3f ray_C = BackProject(k, u, v, 1).cast<float>();
    return Ray{R_OC * ray_C.normalized(), 0, 0, index};
  };
  // Sets the part of the ray within the bounding sphere grown by the spread.
  const auto enters = [&](Ray& ray, const Eigen::Vector3f& direction_C, float spread) {
    const float along = direction_C.dot(center_C);
    const float reach_m = radius_m + spread * along;
    const float squared = reach_m * reach_m - (center_C - along * direction_C).squaredNorm();
    if (squared <= 0) return false;
    ray.along_m = std::max(along - std::sqrt(squared), 0.0f);
    ray.end_m = along + std::sqrt(squared);
    return true;
  };

  // Blocks of pixels are cones. Only the pixels of blocks that touch the solid have rays.
  const int columns = (k.width() + kBlock_px - 1) / kBlock_px;
  const int rows = (k.height() + kBlock_px - 1) / kBlock_px;
  const float spread = static_cast<float>(0.72 * kBlock_px / std::min(k.fx(), k.fy()));
  std::vector<Ray> cones, rays;
  for (int block = 0; block < columns * rows; ++block) {
    const double u = block % columns * kBlock_px + 0.5 * (kBlock_px - 1);
    const double v = block / columns * kBlock_px + 0.5 * (kBlock_px - 1);
    Ray cone = ray_to(u, v, block);
    if (enters(cone, BackProject(k, u, v, 1).cast<float>().normalized(), spread)) {
      cones.push_back(cone);
    }
  }
  March(distances_m_, eye_O, cones, spread, [&](const Ray& cone) {
    const int left = cone.index % columns * kBlock_px, top = cone.index / columns * kBlock_px;
    for (int y = top; y < std::min(top + kBlock_px, k.height()); ++y) {
      for (int x = left; x < std::min(left + kBlock_px, k.width()); ++x) {
        Ray ray = ray_to(x, y, y * k.width() + x);
        if (!enters(ray, BackProject(k, x, y, 1).cast<float>().normalized(), 0)) continue;
        ray.along_m = std::max(ray.along_m, cone.along_m * (1 - spread));
        if (ray.along_m < ray.end_m) rays.push_back(ray);
      }
    }
  });
  March(distances_m_, eye_O, rays, 0, [&](const Ray& ray) {
    const Eigen::Vector3d p_O = (eye_O + ray.along_m * ray.direction_O).cast<double>();
    depth_m.pixels()[ray.index] = static_cast<float>((X_CO * p_O).z());
  });
  return depth_m;
}

void TracedSolid::Inside(std::span<const Eigen::Vector3f> points_O,
                         std::span<uint8_t> inside) const {
  std::vector<float> values(points_O.size());
  distances_m_(points_O, values);
  for (size_t i = 0; i < values.size(); ++i) inside[i] = values[i] <= 0;
}

float TracedSolid::LowestAlong(const Eigen::Vector3f& normal_O) const {
  constexpr int kSamples = 4096, kRefined = 32, kSteps = 12;
  Rng rng(0);
  std::vector<Eigen::Vector3f> points(kSamples);
  for (Eigen::Vector3f& p : points) {
    const Eigen::Array3f share(rng.Uniform(), rng.Uniform(), rng.Uniform());
    p = box_O_.min() + (share * box_O_.sizes().array()).matrix();
  }
  std::vector<float> values(kSamples);
  distances_m_(points, values);
  // A point at depth d inside the solid is the center of a ball of radius d inside it.
  std::vector<std::pair<float, int>> lowest;
  for (int i = 0; i < kSamples; ++i) {
    if (values[i] <= 0) lowest.emplace_back(normal_O.dot(points[i]) + values[i], i);
  }
  if (lowest.empty()) return normal_O.dot(box_O_.center());
  const size_t kept = std::min<size_t>(lowest.size(), kRefined);
  std::partial_sort(lowest.begin(), lowest.begin() + kept, lowest.end());
  std::vector<Eigen::Vector3f> refined(kept);
  for (size_t i = 0; i < kept; ++i) refined[i] = points[lowest[i].second];
  values.resize(kept);
  float best = lowest.front().first;
  for (int step = 0; step < kSteps; ++step) {
    distances_m_(refined, values);
    for (size_t i = 0; i < kept; ++i) {
      if (values[i] > 0) continue;
      best = std::min(best, normal_O.dot(refined[i]) + values[i]);
      refined[i] += values[i] * normal_O;
    }
  }
  return best;
}

}  // namespace pickbed::perception
