#include "grasp/candidates/pad_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace pickbed::grasp {
namespace {

// Surface tilted by more than 60 degrees against a pad cannot support it.
constexpr double kFacingCosine = 0.5;

// Accumulates the contact of one pad.
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
  surface.points_O.resize(count, 3);
  surface.normals_O.resize(count, 3);
  for (int i = 0; i < count; ++i) {
    surface.points_O.row(i) = samples.points[i].transpose().cast<float>();
    surface.normals_O.row(i) = samples.normals[i].transpose().cast<float>();
  }
  surface.area_m2 = area / count;
  return surface;
}

PointColumns Rotated(const PointColumns& points_O, const Eigen::Matrix3d& R_OG) {
  const Eigen::Matrix3f R = R_OG.cast<float>();
  PointColumns turned(points_O.rows(), 3);
  for (int axis = 0; axis < 3; ++axis) {
    turned.col(axis) =
        points_O.col(0) * R(0, axis) + points_O.col(1) * R(1, axis) + points_O.col(2) * R(2, axis);
  }
  return turned;
}

std::optional<double> JawOpening_m(const HandSpec& hand, double clearance_m, double width_m) {
  const double opening_m = width_m + 2 * clearance_m;
  if (!(opening_m <= hand.stroke_m)) return std::nullopt;  // also for a width that is no number
  return opening_m;
}

PadContact ClosePads(const SurfacePoints& surface, const PointColumns& turned, const Pose& X_OG,
                     const HandSpec& hand, double band_m) {
  const Eigen::Matrix3d R_GO = X_OG.linear().transpose();
  const Eigen::Vector3f origin = (R_GO * X_OG.translation()).cast<float>();
  const float half_width = 0.5 * hand.finger_size_m.y();
  const float low_z = origin.z() - hand.finger_size_m.z();
  const float half_stroke = 0.5 * hand.stroke_m;
  PadContact contact;
  std::vector<int> inside(turned.rows());
  int count = 0;
  for (int i = 0; i < turned.rows(); ++i) {
    inside[count] = i;
    count += (std::abs(turned(i, 1) - origin.y()) <= half_width) & (turned(i, 2) <= origin.z()) &
             (turned(i, 2) >= low_z) & (std::abs(turned(i, 0) - origin.x()) <= half_stroke);
  }
  float low_x = origin.x() + half_stroke, high_x = origin.x() - half_stroke;
  for (int k = 0; k < count; ++k) {
    low_x = std::min(low_x, turned(inside[k], 0));
    high_x = std::max(high_x, turned(inside[k], 0));
  }

  Patch low, high;
  const float band = band_m;
  for (int k = 0; k < count; ++k) {
    const int i = inside[k];
    const bool near_low = turned(i, 0) < low_x + band;
    const bool near_high = turned(i, 0) > high_x - band;
    if (!near_low && !near_high) continue;
    const Eigen::Vector3f p_G = turned.row(i).matrix().transpose() - origin;
    const Eigen::Vector3d p = p_G.cast<double>();
    const Eigen::Vector3d normal =
        R_GO * surface.normals_O.row(i).matrix().transpose().cast<double>();
    if (near_low && normal.x() < -kFacingCosine) low.Add(p, normal);
    if (near_high && normal.x() > kFacingCosine) high.Add(p, normal);
  }
  if (low.count == 0 || high.count == 0) return contact;
  contact.touches = true;
  contact.low_x_m = low_x - origin.x();
  contact.high_x_m = high_x - origin.x();
  contact.area_m2 = std::min(low.count, high.count) * surface.area_m2;
  contact.max_angle_rad =
      std::max(low.AngleTo(-Eigen::Vector3d::UnitX()), high.AngleTo(Eigen::Vector3d::UnitX()));
  contact.shared_min = low.min.cwiseMax(high.min);
  contact.shared_max = low.max.cwiseMin(high.max);
  return contact;
}

std::array<PadPatch, 2> TouchedPatches(const SurfacePoints& surface, const PointColumns& turned,
                                       const Pose& X_OG, const HandSpec& hand,
                                       const PadContact& contact, double band_m) {
  const Eigen::Matrix3d R_GO = X_OG.linear().transpose();
  const Eigen::Vector3d origin = R_GO * X_OG.translation();
  const float low_x = origin.x() + contact.low_x_m, high_x = origin.x() + contact.high_x_m;
  const float band = band_m, half_width = 0.5 * hand.finger_size_m.y();
  const float half_stroke = 0.5 * hand.stroke_m;
  const float x = origin.x(), y = origin.y(), high_z = origin.z(),
              low_z = origin.z() - hand.finger_size_m.z();
  std::array<PadPatch, 2> patches;
  for (int i = 0; i < turned.rows(); ++i) {
    if (std::abs(turned(i, 1) - y) > half_width || turned(i, 2) > high_z || turned(i, 2) < low_z) {
      continue;
    }
    if (std::abs(turned(i, 0) - x) > half_stroke) continue;
    const bool near_low = turned(i, 0) < low_x + band;
    const bool near_high = turned(i, 0) > high_x - band;
    if (!near_low && !near_high) continue;
    const Eigen::Vector3d normal =
        R_GO * surface.normals_O.row(i).matrix().transpose().cast<double>();
    const Eigen::Vector3d p = turned.row(i).matrix().transpose().cast<double>() - origin;
    const auto add = [&](PadPatch& patch) {
      patch.points_G.push_back(p);
      patch.normal_G += normal;
    };
    if (near_low && normal.x() < -kFacingCosine) add(patches[0]);
    if (near_high && normal.x() > kFacingCosine) add(patches[1]);
  }
  for (PadPatch& patch : patches) patch.normal_G.normalize();
  return patches;
}

bool HandClearsObject(const PointColumns& turned, const Pose& X_OG,
                      std::span<const AxisAlignedBox> boxes_G, double margin_m) {
  const Eigen::Vector3d origin = X_OG.linear().transpose() * X_OG.translation();
  const float* x = turned.col(0).data();
  const float* y = turned.col(1).data();
  const float* z = turned.col(2).data();
  for (const AxisAlignedBox& box : boxes_G) {
    const Eigen::Vector3f center = (origin + box.center).cast<float>();
    const Eigen::Vector3f reach = (box.half_size.array() + margin_m).cast<float>();
    const float front_z = center.z() + reach.z();
    // No early exit: without branches the compiler tests four points at once.
    int met = 0;
    for (int i = 0; i < turned.rows(); ++i) {
      met += (z[i] < front_z) & (std::abs(x[i] - center.x()) < reach.x()) &
             (std::abs(y[i] - center.y()) < reach.y());
    }
    if (met > 0) return false;
  }
  return true;
}

}  // namespace pickbed::grasp
