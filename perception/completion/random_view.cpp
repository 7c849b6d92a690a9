#include "perception/completion/random_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/error.h"

namespace pickbed::perception {
namespace {

constexpr int kMaxViews = 50;
// The window reaches this share of the sphere's diameter from its center.
constexpr double kWindowReach = 0.95;
// A reading farther from the true surface is a flying pixel, which no segment contains.
constexpr float kFlying_m = 0.012f;
constexpr float kWall_m = 0.6f;  // background where the floor is not visible, behind the solid

enum Id : uint8_t { kNothing, kSolid, kOther };

double LogUniform(Rng& rng, double low, double high) {
  return low * std::pow(high / low, rng.Uniform());
}

CameraIntrinsics DrawCamera(const ViewedSolid& solid, const RandomViewOptions& options, Rng& rng,
                            Pose& X_CO) {
  const double diameter_m = solid.box_O().diagonal().norm();
  const double z_m =
      std::max(rng.Uniform(options.min_distance_m, options.max_distance_m), 1.5 * diameter_m);
  const double across_x = rng.Uniform(-options.max_off_axis, options.max_off_axis);
  const double across_y = rng.Uniform(-options.max_off_axis, options.max_off_axis);
  const double diameter_px = LogUniform(rng, options.min_diameter_px, options.max_diameter_px);
  const double focal_px = diameter_px * z_m / diameter_m;
  const int size = 2 * static_cast<int>(std::ceil(kWindowReach * diameter_px)) + 1;
  X_CO = Pose::Identity();
  X_CO.linear() = rng.Rotation().toRotationMatrix();
  const Eigen::Vector3d center_C = z_m * Eigen::Vector3d(across_x, across_y, 1);
  X_CO.translation() = center_C - X_CO.linear() * solid.box_O().center().cast<double>();
  const double center_px = 0.5 * (size - 1);
  return {size,
          size,
          focal_px,
          focal_px,
          center_px - focal_px * across_x,
          center_px - focal_px * across_y};
}

// Draws a plane below the solid: in contact, or farther away as the bottom of a bin.
FloorPlane DrawFloor(const ViewedSolid& solid, const Pose& X_CO, Rng& rng) {
  Eigen::Vector3d normal_C;
  do {
    normal_C = rng.UnitVector();
  } while (normal_C.z() > -0.7);
  FloorPlane floor;
  floor.normal_C = normal_C.cast<float>();
  const Eigen::Vector3d normal_O = X_CO.linear().transpose() * normal_C;
  const float lowest_m = solid.LowestAlong(normal_O.cast<float>()) +
                         static_cast<float>(normal_C.dot(X_CO.translation()));
  const bool in_contact = rng.Uniform() < 0.65;
  const double gap_m = rng.Uniform(0, 0.06);
  floor.offset_m = lowest_m - static_cast<float>(in_contact ? 0 : gap_m);
  return floor;
}

void AddBackground(const CameraIntrinsics& k, const FloorPlane& floor, float wall_m,
                   Image<float>& depth_m) {
  for (int y = 0; y < k.height(); ++y) {
    for (int x = 0; x < k.width(); ++x) {
      if (depth_m(x, y) > 0) continue;
      const Eigen::Vector3f ray_C = BackProject(k, x, y, 1).cast<float>();
      const float slope = floor.normal_C.dot(ray_C);
      const float z_m = slope < -1e-3f ? floor.offset_m / slope : wall_m;
      depth_m(x, y) = z_m > 0 && z_m < wall_m ? z_m : wall_m;
    }
  }
}

// Removes the segment's pixels next to other pixels.
void Erode(Image<uint8_t>& segment) {
  const Image<uint8_t> before = segment;
  for (int y = 0; y < before.height(); ++y) {
    for (int x = 0; x < before.width(); ++x) {
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (before.Contains(x + dx, y + dy) && !before(x + dx, y + dy)) segment(x, y) = 0;
      }
    }
  }
}

// Draws a view that may have too few pixels.
RandomView TryView(const ViewedSolid& solid, const std::vector<DepthSensor>& sensors,
                   const RandomViewOptions& options, Rng& rng) {
  RandomView drawn;
  SegmentView& view = drawn.view;
  view.intrinsics = DrawCamera(solid, options, rng, drawn.X_CO);
  const CameraIntrinsics& k = view.intrinsics;
  Image<float> ideal_m = solid.Depth(k, drawn.X_CO);
  Image<uint8_t> ids(k.width(), k.height(), kNothing);
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ideal_m.pixels()[i] > 0) ids.pixels()[i] = kSolid;
  }
  const FloorPlane floor = DrawFloor(solid, drawn.X_CO, rng);
  if (rng.Uniform() < options.floor_share) view.floor = floor;
  const float wall_m = static_cast<float>(drawn.X_CO.translation().z()) + kWall_m;
  AddBackground(k, floor, wall_m, ideal_m);
  drawn.is_occluded = rng.Uniform() < options.occluded_share;
  const double hidden = rng.Uniform(options.min_hidden, options.max_hidden);
  if (drawn.is_occluded) {
    const Image<uint8_t> occluder = DrawOccluder(hidden, ids, rng, ideal_m);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (occluder.pixels()[i]) ids.pixels()[i] = kOther;
    }
  }
  view.depth_m = sensors.empty()
                     ? ideal_m
                     : sensors[rng.Index(static_cast<int>(sensors.size()))](ideal_m, k, rng);
  view.segment = Image<uint8_t>(k.width(), k.height(), 0);
  view.occluders = Image<uint8_t>(k.width(), k.height(), 0);
  for (size_t i = 0; i < ids.size(); ++i) {
    float& read_m = view.depth_m.pixels()[i];
    if (!(read_m > 0)) continue;
    if (ids.pixels()[i] == kNothing) continue;
    if (std::abs(read_m - ideal_m.pixels()[i]) > kFlying_m) {
      read_m = 0;
      continue;
    }
    (ids.pixels()[i] == kSolid ? view.segment : view.occluders).pixels()[i] = 1;
  }
  if (rng.Uniform() < options.eroded_share) Erode(view.segment);
  return drawn;
}

}  // namespace

void RandomViewOptions::Visit(SettingsVisitor& v) {
  v.Real("min_distance_m", min_distance_m, {0.1, 10}, "smallest distance of the solid, m");
  v.Real("max_distance_m", max_distance_m, {0.1, 10}, "largest distance of the solid, m");
  v.Real("max_off_axis", max_off_axis, {0, 1},
         "largest distance of the solid from the optical axis, over its depth");
  v.Real("min_diameter_px", min_diameter_px, {10, 1000}, "smallest diameter in the image, px");
  v.Real("max_diameter_px", max_diameter_px, {10, 1000}, "largest diameter in the image, px");
  v.Real("occluded_share", occluded_share, {0, 1}, "share of the views with an occluder");
  v.Real("min_hidden", min_hidden, {0, 0.9}, "smallest share of the pixels that it hides");
  v.Real("max_hidden", max_hidden, {0, 0.9}, "largest share of the pixels that it hides");
  v.Real("floor_share", floor_share, {0, 1}, "share of the views with a known floor");
  v.Real("eroded_share", eroded_share, {0, 1},
         "share of the views whose segment lacks its outermost pixels");
}

Image<uint8_t> DrawOccluder(double hidden, const Image<uint8_t>& solid, Rng& rng,
                            Image<float>& depth_m) {
  Image<uint8_t> occluder(solid.width(), solid.height(), 0);
  const bool is_disc = rng.Uniform() < 0.5;
  const double angle_rad = rng.Uniform(0, 2 * std::numbers::pi);
  const double aside = rng.Uniform(0.4, 1.2);
  const Eigen::Vector2d axis(std::cos(angle_rad), std::sin(angle_rad));
  const double half = 0.5 * (solid.width() - 1);
  const Eigen::Vector2d center = Eigen::Vector2d(half, half) + aside * 0.5 * half * axis;
  const auto measure = [&](int x, int y) {
    const Eigen::Vector2d at(x, y);
    return is_disc ? (at - center).norm() : -axis.dot(at);
  };
  std::vector<double> values;
  for (int y = 0; y < solid.height(); ++y) {
    for (int x = 0; x < solid.width(); ++x) {
      if (solid(x, y) != 0) values.push_back(measure(x, y));
    }
  }
  if (values.empty()) return occluder;
  const size_t count = static_cast<size_t>(hidden * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + count, values.end());
  const double limit = values[count];
  float nearest_m = 1e9f;
  for (int y = 0; y < solid.height(); ++y) {
    for (int x = 0; x < solid.width(); ++x) {
      if (solid(x, y) != 0 && measure(x, y) < limit) {
        nearest_m = std::min(nearest_m, depth_m(x, y));
      }
    }
  }
  if (nearest_m > 1e8f) return occluder;
  const double gap_m = LogUniform(rng, 0.003, 0.08);
  const float top_m = nearest_m - static_cast<float>(std::min(gap_m, 0.4 * nearest_m));
  for (int y = 0; y < solid.height(); ++y) {
    for (int x = 0; x < solid.width(); ++x) {
      if (measure(x, y) >= limit) continue;
      occluder(x, y) = 1;
      depth_m(x, y) = top_m;
    }
  }
  return occluder;
}

RandomView DrawView(const ViewedSolid& solid, const std::vector<DepthSensor>& sensors,
                    const RandomViewOptions& options, Rng& rng) {
  for (int i = 0; i < kMaxViews; ++i) {
    RandomView drawn = TryView(solid, sensors, options, rng);
    if (SegmentPixels(drawn.view) >= kMinSegmentPixels) return drawn;
  }
  throw InputError("no random view of the solid shows enough of it; raise min_diameter_px");
}

}  // namespace pickbed::perception
