#include "grasp/pad_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pickbed {
namespace {

// Surface turned further than this from a pad cannot be what the pad rests on.
constexpr double kFacingCosine = 0.5;

// One pad's contact while it is gathered.
struct Patch {
  int count = 0;
  Eigen::Vector3d normal_sum = Eigen::Vector3d::Zero();
  Eigen::Vector2d min = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());

  void Add(const Eigen::Vector3d& p_G, const Eigen::Vector3d& normal_G) {
    ++count;
    normal_sum += normal_G;
    min = min.cwiseMin(p_G.tail<2>());
    max = max.cwiseMax(p_G.tail<2>());
  }

  double AngleTo(const Eigen::Vector3d& axis) const {
    return std::acos(std::clamp(normal_sum.normalized().dot(axis), -1.0, 1.0));
  }
};

}  // namespace

SurfacePoints SpreadPoints(const TriangleMesh& mesh, double spacing_m, int min_count, int max_count,
                           Rng& rng) {
  const double area = SurfaceArea(mesh);
  const double wanted = area / (spacing_m * spacing_m);
  const int count = static_cast<int>(std::clamp(wanted, double(min_count), double(max_count)));
  const SurfaceSamples samples = SampleSurface(mesh, count, rng);
  SurfacePoints surface;
  surface.points_O.resize(3, count);
  surface.normals_O.resize(3, count);
  for (int i = 0; i < count; ++i) {
    surface.points_O.col(i) = samples.points[i];
    surface.normals_O.col(i) = samples.normals[i];
  }
  surface.area_m2 = area / count;
  return surface;
}

PadContact ClosePads(const SurfacePoints& surface, const Pose& X_OG, const HandSpec& hand,
                     double band_m) {
  const Eigen::Matrix3d R_GO = X_OG.linear().transpose();
  const Eigen::Matrix3Xd points_G = R_GO * (surface.points_O.colwise() - X_OG.translation());
  const Eigen::Vector3d size = hand.finger_size_m;
  const auto between_pads = [&](const auto& p) {
    return std::abs(p.y()) <= 0.5 * size.y() && p.z() <= 0 && p.z() >= -size.z() &&
           std::abs(p.x()) <= 0.5 * hand.stroke_m;
  };

  PadContact contact;
  contact.low_x_m = std::numeric_limits<double>::infinity();
  contact.high_x_m = -contact.low_x_m;
  std::vector<int> inside;
  for (int i = 0; i < points_G.cols(); ++i) {
    if (!between_pads(points_G.col(i))) continue;
    inside.push_back(i);
    contact.low_x_m = std::min(contact.low_x_m, points_G(0, i));
    contact.high_x_m = std::max(contact.high_x_m, points_G(0, i));
  }

  Patch low, high;
  for (const int i : inside) {
    const Eigen::Vector3d p = points_G.col(i);
    const bool near_low = p.x() < contact.low_x_m + band_m;
    const bool near_high = p.x() > contact.high_x_m - band_m;
    if (!near_low && !near_high) continue;
    const Eigen::Vector3d normal = R_GO * surface.normals_O.col(i);
    if (near_low && normal.x() < -kFacingCosine) low.Add(p, normal);
    if (near_high && normal.x() > kFacingCosine) high.Add(p, normal);
  }
  if (low.count == 0 || high.count == 0) return contact;
  contact.touches = true;
  contact.area_m2 = std::min(low.count, high.count) * surface.area_m2;
  contact.max_angle_rad =
      std::max(low.AngleTo(-Eigen::Vector3d::UnitX()), high.AngleTo(Eigen::Vector3d::UnitX()));
  contact.shared_min = low.min.cwiseMax(high.min);
  contact.shared_max = low.max.cwiseMin(high.max);
  return contact;
}

bool HandClearsPart(const SurfacePoints& surface, const Pose& X_OG, const HandSpec& hand,
                    double opening_m, double margin_m) {
  const Eigen::Matrix3d R_GO = X_OG.linear().transpose();
  const Eigen::Matrix3Xd points_G = R_GO * (surface.points_O.colwise() - X_OG.translation());
  for (const AxisAlignedBox& box : HandBoxes(hand, opening_m)) {
    const Eigen::Vector3d reach = box.half_size.array() + margin_m;
    const double front_z = box.center.z() + reach.z();
    for (int i = 0; i < points_G.cols(); ++i) {
      if (points_G(2, i) < front_z && std::abs(points_G(0, i) - box.center.x()) < reach.x() &&
          std::abs(points_G(1, i) - box.center.y()) < reach.y()) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace pickbed
