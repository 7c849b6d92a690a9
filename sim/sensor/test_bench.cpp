#include "sim/sensor/test_bench.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/math.h"
#include "sim/sensor/depth_noise.h"

namespace pickbed::sim {
namespace {

constexpr uint64_t kSeed = 1;  // fixed, so the sheet of a profile is always the same
constexpr int kDraws = 12;
constexpr double kFocal_px = 600;
// Camera of the measured planes. It is narrow, so that the slant is nearly constant.
constexpr CameraIntrinsics kNarrow{41, 65, kFocal_px, kFocal_px, 20, 32};
constexpr int kMargin_px = 18;  // ignored columns on the left and right, where jitter is clamped

// Result of a ray cast: depth along z, cosine of the slant, and surface color.
struct Hit {
  double z = 0;
  double cosine = 1;
  Rgb8 color{150, 150, 150};
};

void Meet(Hit& hit, double z, double cosine, Rgb8 color) {
  if (z > 0 && z < hit.z) hit = {z, cosine, color};
}

bool Within(double value, double low, double high) { return value >= low && value <= high; }

// Casts the ray (u, v, 1). Lengths are in units of the wall's distance.
Hit Cast(double u, double v) {
  const double ray = std::sqrt(1 + u * u + v * v);
  Hit hit{1, 1 / ray, {150, 150, 150}};
  if (Within(v, 0.10, 0.28) && Within(u, -0.42, -0.30)) hit.color = {8, 8, 8};
  if (Within(v, 0.10, 0.28) && Within(u, -0.26, -0.14)) hit.color = {255, 255, 255};
  const double box_z = 0.8, post_z = 0.75;
  if (Within(u * box_z, -0.32, -0.16) && Within(v * box_z, -0.23, -0.03))
    Meet(hit, box_z, 1 / ray, {200, 130, 80});
  if (Within(u * post_z, -0.04, -0.025) && Within(v * post_z, -0.22, 0.02))
    Meet(hit, post_z, 1 / ray, {190, 90, 90});

  const Eigen::Vector3d direction(u, v, 1), center(0.02, 0.15, 0.85);
  const double radius = 0.09, along = direction.dot(center) / (ray * ray);
  const double beside2 = (direction * along - center).squaredNorm();
  if (beside2 < radius * radius) {
    const double z = along - std::sqrt(radius * radius - beside2) / ray;
    const Eigen::Vector3d normal = (center - direction * z) / radius;
    Meet(hit, z, normal.dot(direction) / ray, {90, 140, 200});
  }
  const double board_degrees[] = {30, 50, 70, 80};
  for (int i = 0; i < 4; ++i) {
    if (!Within(v, -0.32 + 0.16 * i, -0.18 + 0.16 * i)) continue;
    // The board passes through (0.24, ., 0.85), and z grows to the right: z = z0 + tan (x - x0), x
    // = u z.
    const double tangent = std::tan(Radians(board_degrees[i]));
    const double z = (0.85 - 0.24 * tangent) / (1 - u * tangent);
    if (!Within(z, 0.72, 0.99) || !Within(u * z, 0.14, 0.34)) continue;
    const double cosine = std::abs(1 - u * tangent) / (ray * std::hypot(1, tangent));
    Meet(hit, z, cosine, {120, 180, 110});
  }
  return hit;
}

// Renders a plane that intersects the optical axis at `z_m`. It is rotated about camera y towards
// the projector's side.
Image<float> RotatedPlane(const SensorProfile& p, double z_m, double slant_rad) {
  const double tangent = (p.baseline_m < 0 ? -1 : 1) * std::tan(slant_rad);
  Image<float> depth_m(kNarrow.width(), kNarrow.height());
  for (int y = 0; y < kNarrow.height(); ++y) {
    for (int x = 0; x < kNarrow.width(); ++x) {
      const double u = (x - kNarrow.cx()) / kNarrow.fx();
      depth_m(x, y) = static_cast<float>(std::max(0.0, z_m / (1 - u * tangent)));
    }
  }
  return depth_m;
}

NoiseSample Measure(const SensorProfile& p, double z_m, double slant_rad, Rng& rng) {
  const Image<float> ideal = RotatedPlane(p, z_m, slant_rad);
  double sum = 0, sum2 = 0;
  int read = 0, lost = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Image<float> seen = ApplySensorNoise({ideal, kNarrow}, p, rng);
    for (int y = 0; y < kNarrow.height(); ++y) {
      for (int x = kMargin_px; x < kNarrow.width() - kMargin_px; ++x) {
        if (seen(x, y) == 0) {
          ++lost;
          continue;
        }
        const double error = seen(x, y) - ideal(x, y);
        sum += error, sum2 += error * error, ++read;
      }
    }
  }
  NoiseSample sample;
  const double mean = read > 0 ? sum / read : 0;
  sample.measured_m = read > 0 ? std::sqrt(std::max(0.0, sum2 / read - mean * mean)) : 0;
  sample.lost_share = static_cast<double>(lost) / (lost + read);
  const double slope_m = z_m * std::tan(slant_rad) / kFocal_px;  // depth change per pixel
  const double lateral_m = LateralSigma_px(p, slant_rad, kFocal_px) * slope_m;
  const double step_m = ReadingStep_m(p, z_m, kFocal_px);
  sample.axial_m = AxialSigma_m(p, z_m, slant_rad);
  sample.formula_m =
      std::sqrt(sample.axial_m * sample.axial_m + lateral_m * lateral_m + step_m * step_m / 12);
  const double grazing = p.grazing_dropout * std::max(0.0, slant_rad - p.grazing_start_rad) /
                         (std::numbers::pi / 2 - p.grazing_start_rad);
  const double edge = slope_m > p.edge_step_m ? p.edge_dropout : 0;
  sample.lost_formula_share = 1 - (1 - p.random_dropout) * (1 - grazing) * (1 - edge);
  return sample;
}

}  // namespace

double TrialDistance_m(const SensorProfile& profile) {
  return std::clamp(1.0, std::min(1.6 * profile.min_range_m, 0.9 * profile.max_range_m),
                    0.9 * profile.max_range_m);
}

SensorScene MakeSensorScene(double distance_m) {
  SensorScene scene;
  scene.camera = {480, 360, 510, 510, 239.5, 179.5};
  scene.color = Image<Rgb8>(scene.camera.width(), scene.camera.height());
  scene.depth_m = Image<float>(scene.camera.width(), scene.camera.height());
  for (int y = 0; y < scene.camera.height(); ++y) {
    for (int x = 0; x < scene.camera.width(); ++x) {
      const Hit hit = Cast((x - scene.camera.cx()) / scene.camera.fx(),
                           (y - scene.camera.cy()) / scene.camera.fy());
      const auto shade = [&](uint8_t c) {
        return static_cast<uint8_t>(c * (0.35 + 0.65 * std::min(1.0, hit.cosine)));
      };
      const bool highlight = hit.color == Rgb8{255, 255, 255};  // bright at any slant
      scene.color(x, y) =
          highlight ? hit.color : Rgb8{shade(hit.color.r), shade(hit.color.g), shade(hit.color.b)};
      scene.depth_m(x, y) = static_cast<float>(hit.z * distance_m);
    }
  }
  return scene;
}

std::vector<NoiseSample> NoiseByDistance(const SensorProfile& profile) {
  constexpr int kSteps = 13;
  const double near_m = std::max(1.05 * profile.min_range_m, 0.2);
  const double far_m = std::max(near_m, std::min(0.95 * profile.max_range_m, 4.0));
  Rng rng = Rng::Derive(kSeed, 0, "noise by distance");
  std::vector<NoiseSample> samples;
  for (int i = 0; i < kSteps; ++i) {
    const double z_m = near_m + (far_m - near_m) * i / (kSteps - 1);
    samples.push_back(Measure(profile, z_m, 0, rng));
    samples.back().at = z_m;
  }
  return samples;
}

std::vector<NoiseSample> NoiseBySlant(const SensorProfile& profile, double distance_m) {
  Rng rng = Rng::Derive(kSeed, 0, "noise by slant");
  std::vector<NoiseSample> samples;
  for (int degrees = 0; degrees <= 84; degrees += 6) {
    samples.push_back(Measure(profile, distance_m, Radians(degrees), rng));
    samples.back().at = Radians(degrees);
  }
  return samples;
}

}  // namespace pickbed::sim
