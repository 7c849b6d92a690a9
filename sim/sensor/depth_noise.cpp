#include "sim/sensor/depth_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/settings.h"
#include "scenes/camera/mesh_raster_rows.h"
#include "sim/sensor/image_geometry.h"
#include "sim/sensor/noise_streams.h"
#include "sim/sensor/window_matching.h"

namespace pickbed::sim {
namespace {

// Returns the depth of the 4-neighbor with a reading that differs most. A flying pixel is mixed
// with it.
float OtherSurface(const Image<float>& depth_m, int x, int y) {
  const float z = depth_m(x, y);
  float other = z;
  const auto consider = [&](int nx, int ny) {
    if (!depth_m.Contains(nx, ny) || !(depth_m(nx, ny) > 0)) return;
    if (std::abs(depth_m(nx, ny) - z) > std::abs(other - z)) other = depth_m(nx, ny);
  };
  consider(x - 1, y), consider(x + 1, y), consider(x, y - 1), consider(x, y + 1);
  return other;
}

// EdgeDistances_px() stores distances as uint8_t.
static_assert(kWidestWindow_px / 2 <= std::numeric_limits<uint8_t>::max());

// Constants of the loops over a row, as floats.
struct RowConstants {
  explicit RowConstants(const SensorProfile& p, double image_focal_px);
  float kept, edge_dropout;  // kept = 1 - random_dropout
  float window_reach_px;     // half a window
  float grazing_per_rad, grazing_start_rad;
  float floor_m, linear_m, square_m, slant_m;
  int slant_half_power;
  float lateral_px, lateral_slant_px;
  float dark_dropout, per_dark_luma, shiny_dropout, shiny_start, per_shiny_luma;  // lumas in 0..1
  float edge_step_m;
  float flying_share;
  float disparity_steps_m;  // f b / step: disparity of 1 m in steps; 0 = no steps
  float quantum_m;
  float min_m, max_m;
};

RowConstants::RowConstants(const SensorProfile& p, double image_focal_px) {
  const auto f = [](double value) { return static_cast<float>(value); };
  kept = f(1 - p.random_dropout), edge_dropout = f(p.edge_dropout);
  window_reach_px = f(WindowWidth_px(p, image_focal_px) / 2);
  grazing_per_rad = f(p.grazing_dropout / (std::numbers::pi / 2 - p.grazing_start_rad));
  grazing_start_rad = f(p.grazing_start_rad);
  floor_m = f(p.axial_floor_m), linear_m = f(p.axial_linear_m), square_m = f(p.axial_sigma_m);
  slant_m = f(p.axial_slant_m);
  slant_half_power = static_cast<int>(std::lround(2 * p.axial_slant_power));
  const double lateral_scale = LateralScale(p, image_focal_px);
  lateral_px = f(lateral_scale * p.lateral_sigma_px);
  lateral_slant_px = f(lateral_scale * p.lateral_slant_px);
  dark_dropout = f(p.dark_dropout), per_dark_luma = f(1 / p.dark_luma);
  shiny_dropout = f(p.shiny_dropout), shiny_start = f(p.shiny_luma);
  per_shiny_luma = f(1 / (1 - p.shiny_luma));
  edge_step_m = f(p.edge_step_m);
  flying_share = f(p.flying_share);
  const double focal_px = p.disparity_focal_px > 0 ? p.disparity_focal_px : image_focal_px;
  disparity_steps_m =
      p.disparity_step_px > 0 ? f(focal_px * TriangulationBaseline_m(p) / p.disparity_step_px) : 0;
  quantum_m = f(p.quantization_m);
  min_m = f(p.min_range_m), max_m = f(p.max_range_m);
}

// Values of each pixel of one row.
struct RowState {
  explicit RowState(int n)
      : is_edge(n),
        is_shadow(n),
        sees_edge(n),
        survival(n),
        slant_ratio(n),
        slant_sigma_m(n),
        pixel(n),
        right(n),
        down(n),
        upper_m(2 * n),
        lower_m(2 * n),
        seen_m(n) {}
  std::vector<uint8_t> is_edge, is_shadow;
  std::vector<float> sees_edge;         // 1 at an edge, 0 where no window sees one
  std::vector<float> survival;          // probability of a reading
  std::vector<float> slant_ratio;       // a / (pi/2 - a) of slant a
  std::vector<float> slant_sigma_m;     // part of sigma due to slant
  std::vector<int> pixel;               // upper left neighbor of the observed position
  std::vector<float> right, down;       // offset of the position from it, in pixels
  std::vector<float> upper_m, lower_m;  // depths of the four pixels around it, in pairs
  std::vector<float> seen_m;            // depth at the position, 0 = none
};

// Outputs are marked __restrict (no overlap with inputs). Without it the compiler does not
// vectorize the loop.

PICKBED_WIDTHS void FillSurvival(RowConstants c, const float* sees_edge, const uint8_t* is_shadow,
                                 int n, float* __restrict survival) {
  for (int x = 0; x < n; ++x) {
    const float kept = c.kept * (1.0f - c.edge_dropout * sees_edge[x]);
    survival[x] = is_shadow[x] ? 0.0f : kept;
  }
}

// Computes how much of an edge a pixel's window sees. It falls linearly with the distance.
PICKBED_WIDTHS void FillSeenEdges(float reach_px, const uint8_t* distance_px, int n,
                                  float* __restrict sees_edge) {
  for (int x = 0; x < n; ++x) {
    sees_edge[x] = std::max(0.0f, 1.0f - static_cast<float>(distance_px[x]) / reach_px);
  }
}

// Luma is Rec. 601 in 8 bits. A reading survives if neither darkness nor shine removes it.
PICKBED_WIDTHS void ThinByLuma(RowConstants c, const Rgb8* color, int n,
                               float* __restrict survival) {
  for (int x = 0; x < n; ++x) {
    const int luma255 = (77 * color[x].r + 150 * color[x].g + 29 * color[x].b + 128) >> 8;
    const float luma = static_cast<float>(luma255) * (1.0f / 255);
    const float dark = std::max(1.0f - luma * c.per_dark_luma, 0.0f);
    const float shiny = std::max((luma - c.shiny_start) * c.per_shiny_luma, 0.0f);
    survival[x] *= (1.0f - c.dark_dropout * dark) * (1.0f - c.shiny_dropout * shiny);
  }
}

PICKBED_WIDTHS void FillSlant(RowConstants c, const float* slant_rad, const float* depth_m, int n,
                              float* survival, float* ratio, float* sigma_m) {
  constexpr auto kRightAngle = static_cast<float>(std::numbers::pi / 2);
  constexpr auto kSteepest = static_cast<float>(kSteepestSlant_rad);
  for (int x = 0; x < n; ++x) {
    const float a = slant_rad[x];
    survival[x] *= 1.0f - c.grazing_per_rad * std::max(a - c.grazing_start_rad, 0.0f);
    const float steep = std::min(a, kSteepest);
    ratio[x] = steep / (kRightAngle - steep);
    sigma_m[x] = c.slant_m * ratio[x] * ratio[x];
  }
  const int whole = std::abs(c.slant_half_power) / 2, half = std::abs(c.slant_half_power) % 2;
  for (int x = 0; x < n; ++x) {
    const float z = std::max(depth_m[x], 1e-6f);
    const float base = c.slant_half_power < 0 ? 1.0f / z : z;
    const float root = half ? std::sqrt(base) : 1.0f;
    const float square = whole > 1 ? base * base : 1.0f;
    sigma_m[x] *= root * (whole % 2 ? base * square : square);
  }
}

// Computes the position that each pixel of row y observes, for images of at least 2 x 2 px. `pixel`
// is the index of its upper left neighbor. `right` and `down` are the offsets from it in pixels,
// 0..1.
PICKBED_WIDTHS void PlacesAside(RowConstants c, int width, int height, int y, const float* aside,
                                const float* below, const float* slant_ratio, int* __restrict pixel,
                                float* __restrict right, float* __restrict down) {
  const auto u_max = static_cast<float>(width - 1), v_max = static_cast<float>(height - 1);
  for (int x = 0; x < width; ++x) {
    const float sigma_px = c.lateral_px + c.lateral_slant_px * slant_ratio[x];
    const float u = std::min(std::max(static_cast<float>(x) + sigma_px * aside[x], 0.0f), u_max);
    const float v = std::min(std::max(static_cast<float>(y) + sigma_px * below[x], 0.0f), v_max);
    const int left = std::min(static_cast<int>(u), width - 2);
    const int top = std::min(static_cast<int>(v), height - 2);
    right[x] = u - static_cast<float>(left);
    down[x] = v - static_cast<float>(top);
    pixel[x] = top * width + left;
  }
}

// Loads the depths of the four pixels around each position, in pairs. It is compiled for a single
// vector width, because wide gathers are slower than single loads.
void LoadAround(const float* depth_m, int width, const int* pixel, float* __restrict upper,
                float* __restrict lower) {
  for (int x = 0; x < width; ++x) {
    const float* at = depth_m + pixel[x];
    std::memcpy(upper + 2 * x, at, 2 * sizeof(float));
    std::memcpy(lower + 2 * x, at + width, 2 * sizeof(float));
  }
}

// Interpolates bilinearly on a surface. If the four pixels belong to two surfaces, it takes the
// nearest pixel, because an interpolated depth would be on neither surface.
PICKBED_WIDTHS void Between(float edge_step_m, const float* upper, const float* lower,
                            const float* right, const float* down, int n,
                            float* __restrict seen_m) {
  for (int x = 0; x < n; ++x) {
    const float a = right[x], b = down[x];
    const float z00 = upper[2 * x], z10 = upper[2 * x + 1];
    const float z01 = lower[2 * x], z11 = lower[2 * x + 1];
    const float low = std::min(std::min(z00, z10), std::min(z01, z11));
    const float high = std::max(std::max(z00, z10), std::max(z01, z11));
    const float nearest = b < 0.5f ? (a < 0.5f ? z00 : z10) : (a < 0.5f ? z01 : z11);
    const float between = (1 - b) * ((1 - a) * z00 + a * z10) + b * ((1 - a) * z01 + a * z11);
    seen_m[x] = high - low > edge_step_m ? nearest : between;
  }
}

// Sets the depth at the displaced position of each pixel.
void FindSideSteps(RowConstants c, const Image<float>& depth_m, int y, const SensorNumbers& numbers,
                   RowState& row) {
  const int width = depth_m.width();
  PlacesAside(c, width, depth_m.height(), y, numbers.aside.data(), numbers.below.data(),
              row.slant_ratio.data(), row.pixel.data(), row.right.data(), row.down.data());
  LoadAround(depth_m.data(), width, row.pixel.data(), row.upper_m.data(), row.lower_m.data());
  Between(c.edge_step_m, row.upper_m.data(), row.lower_m.data(), row.right.data(), row.down.data(),
          width, row.seen_m.data());
}

// Rounds halves to even, for |value| < 2^22.
inline float RoundToWhole(float value) {
  constexpr float kShift = 12582912.0f;  // 1.5 * 2^23: floats this large have no fraction
  return (value + kShift) - kShift;
}

PICKBED_WIDTHS void Read(RowConstants c, const float* ideal_m, const RowState& row,
                         const SensorNumbers& numbers, int n, float* __restrict out_m) {
  const float* seen_m = row.seen_m.data();
  const float* along = numbers.along.data();
  const float* slant_sigma_m = row.slant_sigma_m.data();
  const float* dropout = numbers.dropout.data();
  const float* survival = row.survival.data();
  const float quantum_m = c.quantum_m > 0 ? c.quantum_m : 1.0f;
  for (int x = 0; x < n; ++x) {
    const float seen = seen_m[x];
    const float sigma_m = c.floor_m + (c.linear_m + c.square_m * seen) * seen + slant_sigma_m[x];
    const float noisy = std::max(seen + sigma_m * along[x], 1e-6f);
    const float steps = RoundToWhole(std::min(c.disparity_steps_m / noisy, 4e6f));
    const float by_disparity = c.disparity_steps_m / std::max(steps, 0.5f);
    const float stepped = c.disparity_steps_m > 0 ? by_disparity : noisy;
    const float rounded = quantum_m * RoundToWhole(std::min(stepped / quantum_m, 4e6f));
    const float z = c.quantum_m > 0 ? rounded : stepped;
    const float in_range = z >= c.min_m ? (z <= c.max_m ? z : 0.0f) : 0.0f;
    const float kept = dropout[x] < survival[x] ? in_range : 0.0f;
    out_m[x] = std::min(ideal_m[x], seen) > 0 ? kept : 0.0f;
  }
}

class NoiseMaker {
 public:
  NoiseMaker(const IdealView& view, const SensorProfile& profile, uint64_t key);
  Image<float> Make();

 private:
  void FindEdges(int y);
  void FindShadows(int y);
  void FindChances(int y);
  void LookAt(int y);
  void MixFlyingPixels(int y);

  const Image<float>& depth_m_;
  const Image<Rgb8>* color_;
  const uint64_t key_;
  const bool needs_slant_, needs_edges_, needs_luma_, needs_shadow_, needs_jitter_;
  const RowConstants constants_;
  RowState row_;
  SensorNumbers numbers_;
  std::optional<CorrelatedNumbers> correlated_;
  Image<uint8_t> edge_distance_px_;  // empty if windows see only their own pixel
  SlantRows slants_;
  ShadowRows shadows_;                        // of the projector
  std::optional<ShadowRows> sensor_shadows_;  // of the sensor's own camera
  std::vector<uint8_t> is_sensor_shadow_;
};

NoiseMaker::NoiseMaker(const IdealView& view, const SensorProfile& p, uint64_t key)
    : depth_m_(view.depth_m),
      color_(view.color && !view.color->empty() ? view.color : nullptr),
      key_(key),
      needs_slant_(p.axial_slant_m > 0 || p.lateral_slant_px > 0 || p.grazing_dropout > 0),
      needs_edges_(p.edge_dropout > 0 || p.flying_share > 0),
      needs_luma_(color_ && (p.dark_dropout > 0 || p.shiny_dropout > 0)),
      needs_shadow_(p.baseline_m != 0),
      needs_jitter_((p.lateral_sigma_px > 0 || p.lateral_slant_px > 0) && depth_m_.width() > 1 &&
                    depth_m_.height() > 1),
      constants_(p, view.intrinsics.fx()),
      row_(depth_m_.width()),
      numbers_(depth_m_.width()),
      slants_(depth_m_, view.intrinsics),
      shadows_(depth_m_.width(), view.intrinsics.fx(), p.baseline_m, constants_.edge_step_m) {
  const double spacing_px = ErrorSpacing_px(p, view.intrinsics.fx());
  if (spacing_px > 0) correlated_.emplace(key, depth_m_.width(), spacing_px);
  if (constants_.window_reach_px > 1 && p.edge_dropout > 0) {
    edge_distance_px_ =
        EdgeDistances_px(depth_m_, constants_.edge_step_m,
                         static_cast<uint8_t>(std::ceil(constants_.window_reach_px)));
  }
  if (p.sensor_x_m != 0) {
    sensor_shadows_.emplace(depth_m_.width(), view.intrinsics.fx(), p.sensor_x_m,
                            constants_.edge_step_m);
    is_sensor_shadow_.resize(depth_m_.width());
  }
}

void NoiseMaker::FindEdges(int y) {
  const int width = depth_m_.width();
  if (edge_distance_px_.empty()) {
    EdgeRow(depth_m_, y, constants_.edge_step_m, row_.is_edge.data());
    std::copy_n(row_.is_edge.data(), width, row_.sees_edge.data());
  } else {
    const uint8_t* distance_px = edge_distance_px_.row(y);
    std::transform(distance_px, distance_px + width, row_.is_edge.begin(),
                   [](uint8_t distance) { return distance == 0; });
    FillSeenEdges(constants_.window_reach_px, distance_px, width, row_.sees_edge.data());
  }
}

void NoiseMaker::FindShadows(int y) {
  std::fill(row_.is_shadow.begin(), row_.is_shadow.end(), uint8_t{0});
  if (needs_shadow_) shadows_.Row(depth_m_.row(y), row_.is_shadow.data());
  if (!sensor_shadows_) return;
  sensor_shadows_->Row(depth_m_.row(y), is_sensor_shadow_.data());
  for (size_t x = 0; x < is_sensor_shadow_.size(); ++x) row_.is_shadow[x] |= is_sensor_shadow_[x];
}

void NoiseMaker::FindChances(int y) {
  const int width = depth_m_.width();
  if (needs_edges_) FindEdges(y);
  FindShadows(y);
  FillSurvival(constants_, row_.sees_edge.data(), row_.is_shadow.data(), width,
               row_.survival.data());
  if (needs_slant_) {
    FillSlant(constants_, slants_.Row(y), depth_m_.row(y), width, row_.survival.data(),
              row_.slant_ratio.data(), row_.slant_sigma_m.data());
  }
  if (needs_luma_) {
    ThinByLuma(constants_, color_->row(y), width, row_.survival.data());
  }
}

void NoiseMaker::MixFlyingPixels(int y) {
  for (int x = 0; x < depth_m_.width(); ++x) {
    if (!row_.is_edge[x] || !(numbers_.flying[x] < constants_.flying_share)) continue;
    const float z = depth_m_(x, y);
    // Under the condition that the pixel flies, its number over the share is uniform again.
    const float mix = numbers_.flying[x] / constants_.flying_share;
    row_.seen_m[x] = z + mix * (OtherSurface(depth_m_, x, y) - z);
  }
}

void NoiseMaker::LookAt(int y) {
  if (needs_jitter_) {
    FindSideSteps(constants_, depth_m_, y, numbers_, row_);
  } else {
    std::copy_n(depth_m_.row(y), depth_m_.width(), row_.seen_m.data());
  }
  if (constants_.flying_share > 0) MixFlyingPixels(y);
}

Image<float> NoiseMaker::Make() {
  const int width = depth_m_.width();
  Image<float> out(width, depth_m_.height());
  for (int y = 0; y < out.height(); ++y) {
    const uint64_t place = key_ + static_cast<uint64_t>(y) * static_cast<uint64_t>(width);
    numbers_.Draw(place);
    if (correlated_) correlated_->Fill(y, numbers_);
    FindChances(y);
    LookAt(y);
    Read(constants_, depth_m_.row(y), row_, numbers_, width, out.row(y));
  }
  return out;
}

std::string SizeText(int width, int height) { return fmt::format("{} x {}", width, height); }

}  // namespace

Image<float> ApplySensorNoise(const IdealView& view, const SensorProfile& profile, Rng& rng) {
  CheckSettings("SensorProfile", profile);
  const std::string size = SizeText(view.depth_m.width(), view.depth_m.height());
  const std::string of_camera = SizeText(view.intrinsics.width(), view.intrinsics.height());
  CheckInput(
      size == of_camera,
      fmt::format("the depth image has {} px but the camera has {} px; give both the same size",
                  size, of_camera));
  if (view.color && !view.color->empty()) {
    const std::string of_color = SizeText(view.color->width(), view.color->height());
    CheckInput(
        size == of_color,
        fmt::format(
            "the depth image has {} px but the color image has {} px; give both the same size",
            size, of_color));
  }
  const uint64_t key = rng.Next();
  if (ChangesNothing(profile)) return view.depth_m;
  return NoiseMaker(view, profile, key).Make();
}

}  // namespace pickbed::sim
