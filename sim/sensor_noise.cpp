#include "sim/sensor_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "scenes/check.h"
#include "scenes/object_catalog.h"

namespace pickbed {
namespace {

namespace fs = std::filesystem;

// One 64-bit random number serves a pixel: three Gaussians of 12 bits by table and two decisions of
// 14 bits.
constexpr int kGaussBits = 12;
constexpr int kGaussCount = 1 << kGaussBits;
constexpr int kDecisionBits = 14;

double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// Equally likely values of a normal distribution: the inverse of its distribution function at the
// middles of equal steps, scaled to unit variance.
std::array<float, kGaussCount> MakeGaussTable() {
  std::array<double, kGaussCount> values;
  double sum_of_squares = 0;
  for (int i = 0; i < kGaussCount; ++i) {
    const double p = (i + 0.5) / kGaussCount;
    double low = -8, high = 8;
    for (int step = 0; step < 50; ++step) {
      const double middle = 0.5 * (low + high);
      (NormalCdf(middle) < p ? low : high) = middle;
    }
    values[i] = 0.5 * (low + high);
    sum_of_squares += values[i] * values[i];
  }
  const double scale = 1 / std::sqrt(sum_of_squares / kGaussCount);
  std::array<float, kGaussCount> table;
  for (int i = 0; i < kGaussCount; ++i) table[i] = static_cast<float>(values[i] * scale);
  return table;
}

const std::array<float, kGaussCount>& GaussTable() {
  static const std::array<float, kGaussCount> table = MakeGaussTable();
  return table;
}

uint64_t Threshold(double probability) {
  return static_cast<uint64_t>(std::lround(probability * (1 << kDecisionBits)));
}

bool IsEdge(const Image<float>& depth_m, int x, int y, float step_m) {
  const float z = depth_m(x, y);
  const auto differs = [&](int nx, int ny) {
    return depth_m.Contains(nx, ny) && std::abs(depth_m(nx, ny) - z) > step_m;
  };
  return differs(x - 1, y) || differs(x + 1, y) || differs(x, y - 1) || differs(x, y + 1);
}

// Depth at (u, v) between pixels: bilinear on a surface, nearest where the four pixels around are
// of two surfaces, since a reading between them would be of neither.
float Look(const Image<float>& depth_m, float u, float v, float step_m) {
  u = std::clamp(u, 0.0f, static_cast<float>(depth_m.width() - 1));
  v = std::clamp(v, 0.0f, static_cast<float>(depth_m.height() - 1));
  const int x = std::min(static_cast<int>(u), std::max(0, depth_m.width() - 2));
  const int y = std::min(static_cast<int>(v), std::max(0, depth_m.height() - 2));
  const float a = u - x, b = v - y;
  const int right = std::min(x + 1, depth_m.width() - 1);
  const int below = std::min(y + 1, depth_m.height() - 1);
  const float z00 = depth_m(x, y), z10 = depth_m(right, y);
  const float z01 = depth_m(x, below), z11 = depth_m(right, below);
  const auto [low, high] = std::minmax({z00, z10, z01, z11});
  if (high - low > step_m) return b < 0.5f ? (a < 0.5f ? z00 : z10) : (a < 0.5f ? z01 : z11);
  return (1 - b) * ((1 - a) * z00 + a * z10) + b * ((1 - a) * z01 + a * z11);
}

fs::path ProfilePath(const std::string& name_or_path) {
  if (fs::path(name_or_path).extension() == ".yaml") return name_or_path;
  const std::vector<std::string> names = SensorProfileNames();
  CheckInput(std::find(names.begin(), names.end(), name_or_path) != names.end(),
             UnknownNameMessage("sensor", name_or_path, names));
  return AssetsDir() / "sensors" / (name_or_path + ".yaml");
}

bool ChangesNothing(const SensorProfile& p) {
  return p.axial_sigma_m == 0 && p.lateral_sigma_px == 0 && p.edge_dropout == 0 &&
         p.random_dropout == 0 && p.quantization_m == 0 && p.min_range_m == 0 &&
         p.max_range_m >= SensorProfile().max_range_m;
}

}  // namespace

void SensorProfile::Visit(SettingsVisitor& v) {
  v.Text("name", name, {}, "name of the profile");
  v.Real("min_range_m", min_range_m, {0, 100}, "nearest reading, m");
  v.Real("max_range_m", max_range_m, {0, 100}, "farthest reading, m");
  v.Real("axial_sigma_m", axial_sigma_m, {0, 0.1}, "noise of depth at 1 m, m; grows with z^2");
  v.Real("lateral_sigma_px", lateral_sigma_px, {0, 10}, "jitter of where a pixel looks, px");
  v.Real("edge_step_m", edge_step_m, {1e-4, 10}, "depth step to a neighbour that is an edge, m");
  v.Real("edge_dropout", edge_dropout, {0, 1}, "probability of no reading at an edge");
  v.Real("random_dropout", random_dropout, {0, 1}, "probability of no reading anywhere");
  v.Real("quantization_m", quantization_m, {0, 0.1}, "step of the reading, m; 0 = none");
}

std::vector<std::string> SensorProfileNames() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(AssetsDir() / "sensors")) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

SensorProfile LoadSensorProfile(const std::string& name_or_path) {
  const fs::path path = ProfilePath(name_or_path);
  SensorProfile profile;
  ReadSettingsFile(path, [&](SettingsVisitor& v) { profile.Visit(v); });
  CheckInput(profile.min_range_m < profile.max_range_m,
             fmt::format("{}: min_range_m {} must be less than max_range_m {}", path.string(),
                         profile.min_range_m, profile.max_range_m));
  return profile;
}

Image<float> ApplySensorNoise(const Image<float>& ideal_depth_m, const SensorProfile& profile,
                              Rng& rng) {
  if (ChangesNothing(profile)) return ideal_depth_m;
  const auto& gauss = GaussTable();
  const auto gaussian = [&gauss](uint64_t bits) { return gauss[bits & (kGaussCount - 1)]; };
  const uint64_t decision_mask = (1 << kDecisionBits) - 1;
  const uint64_t random_threshold = Threshold(profile.random_dropout);
  const uint64_t edge_threshold = Threshold(profile.edge_dropout);
  const auto sigma_px = static_cast<float>(profile.lateral_sigma_px);
  const auto axial_m = static_cast<float>(profile.axial_sigma_m);
  const auto step_m = static_cast<float>(profile.edge_step_m);
  const auto quantum_m = static_cast<float>(profile.quantization_m);
  const auto min_m = static_cast<float>(profile.min_range_m);
  const auto max_m = static_cast<float>(profile.max_range_m);

  Image<float> out(ideal_depth_m.width(), ideal_depth_m.height());
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const uint64_t bits = rng.Next();  // also for holes: what a pixel gets depends on it alone
      if (!(ideal_depth_m(x, y) > 0)) continue;
      if (((bits >> (3 * kGaussBits)) & decision_mask) < random_threshold) continue;
      const bool edge_decision = (bits >> (3 * kGaussBits + kDecisionBits)) < edge_threshold;
      if (edge_decision && IsEdge(ideal_depth_m, x, y, step_m)) continue;
      float z = sigma_px > 0 ? Look(ideal_depth_m, x + sigma_px * gaussian(bits),
                                    y + sigma_px * gaussian(bits >> kGaussBits), step_m)
                             : ideal_depth_m(x, y);
      if (z <= 0) continue;
      z += axial_m * z * z * gaussian(bits >> (2 * kGaussBits));
      if (quantum_m > 0) z = quantum_m * std::nearbyint(z / quantum_m);
      if (z >= min_m && z <= max_m) out(x, y) = z;
    }
  }
  return out;
}

}  // namespace pickbed
