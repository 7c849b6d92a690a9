#include "sim/sensor_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/check.h"
#include "sim/sensor_rows.h"

namespace pickbed {
namespace {

// One 64-bit random number serves a pixel: three Gaussians of 12 bits by table and two decisions of
// 14 bits.
constexpr int kGaussBits = 12;
constexpr int kGaussCount = 1 << kGaussBits;
constexpr int kDecisionBits = 14;
constexpr int kLossShift = 3 * kGaussBits;
constexpr int kFlyingShift = kLossShift + kDecisionBits;

// The random number of a place in a sequence: SplitMix64 (Steele, Lea and Flood 2014) at that step.
uint64_t MixBits(uint64_t place) {
  uint64_t z = place * 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

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

// The neighbour with a reading that differs most: what a flying pixel is mixed with.
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

// What the profile says of each of the 256 lumas: the chance to be neither too dark nor too shiny.
std::array<float, 256> LumaTable(const SensorProfile& p) {
  std::array<float, 256> survival;
  for (int i = 0; i < 256; ++i) {
    const double luma = i / 255.0;
    const double dark = p.dark_dropout * std::clamp(1 - luma / p.dark_luma, 0.0, 1.0);
    const double shiny =
        p.shiny_dropout * std::clamp((luma - p.shiny_luma) / (1 - p.shiny_luma), 0.0, 1.0);
    survival[i] = static_cast<float>((1 - dark) * (1 - shiny));
  }
  return survival;
}

// The constants of the loops over a row, as floats.
struct RowConstants {
  explicit RowConstants(const SensorProfile& p, double image_focal_px);
  float kept, kept_at_edge;  // 1 - dropout
  float grazing_per_rad, grazing_start_rad;
  float floor_m, linear_m, square_m, slant_m;
  int slant_half_power;
  float lateral_px, lateral_slant_px;
  float edge_step_m;
  float flying_share;
  float disparity_steps_m;  // f b / step: the disparity of 1 m in steps; 0 = not in steps
  float quantum_m;
  float min_m, max_m;
};

RowConstants::RowConstants(const SensorProfile& p, double image_focal_px) {
  const auto f = [](double value) { return static_cast<float>(value); };
  kept = f(1 - p.random_dropout), kept_at_edge = f(1 - p.edge_dropout);
  grazing_per_rad = f(p.grazing_dropout / (std::numbers::pi / 2 - p.grazing_start_rad));
  grazing_start_rad = f(p.grazing_start_rad);
  floor_m = f(p.axial_floor_m), linear_m = f(p.axial_linear_m), square_m = f(p.axial_sigma_m);
  slant_m = f(p.axial_slant_m);
  slant_half_power = static_cast<int>(std::lround(2 * p.axial_slant_power));
  lateral_px = f(p.lateral_sigma_px), lateral_slant_px = f(p.lateral_slant_px);
  edge_step_m = f(p.edge_step_m);
  flying_share = f(p.flying_share);
  const double focal_px = p.disparity_focal_px > 0 ? p.disparity_focal_px : image_focal_px;
  disparity_steps_m =
      p.disparity_step_px > 0 ? f(focal_px * std::abs(p.baseline_m) / p.disparity_step_px) : 0;
  quantum_m = f(p.quantization_m);
  min_m = f(p.min_range_m), max_m = f(p.max_range_m);
}

// What is known of each pixel of one row.
struct RowState {
  explicit RowState(int n)
      : is_edge(n),
        is_shadow(n),
        survival(n),
        slant_ratio(n),
        slant_sigma_m(n),
        loss(n),
        flying(n),
        aside(n),
        below(n),
        along(n),
        seen_m(n) {}
  std::vector<uint8_t> is_edge, is_shadow;
  std::vector<float> survival;             // probability of a reading
  std::vector<float> slant_ratio;          // a / (pi/2 - a) of slant a
  std::vector<float> slant_sigma_m;        // the part of sigma that is due to slant
  std::vector<float> loss, flying;         // decisions, uniform in [0, 1)
  std::vector<float> aside, below, along;  // of unit variance: across in x and y, and in depth
  std::vector<float> seen_m;               // depth of what the pixel sees, 0 = nothing
};

// As in sensor_rows.cpp: versions of the same arithmetic. What is written is marked as apart
// from what is read, without which the compiler would not work on several pixels at once.
#define PICKBED_TWO_WIDTHS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))

PICKBED_TWO_WIDTHS void DrawNumbers(uint64_t place, int n, const float* gauss, RowState& row) {
  constexpr uint64_t kGaussMask = kGaussCount - 1, kMask = (1 << kDecisionBits) - 1;
  constexpr float kUnit = 1.0f / (1 << kDecisionBits);
  float* __restrict loss = row.loss.data();
  float* __restrict flying = row.flying.data();
  float* __restrict aside = row.aside.data();
  float* __restrict below = row.below.data();
  float* __restrict along = row.along.data();
  for (int x = 0; x < n; ++x) {
    const uint64_t bits = MixBits(place + static_cast<uint64_t>(x));
    aside[x] = gauss[bits & kGaussMask];
    below[x] = gauss[(bits >> kGaussBits) & kGaussMask];
    along[x] = gauss[(bits >> (2 * kGaussBits)) & kGaussMask];
    loss[x] = static_cast<float>(static_cast<int>((bits >> kLossShift) & kMask)) * kUnit;
    flying[x] = static_cast<float>(static_cast<int>((bits >> kFlyingShift) & kMask)) * kUnit;
  }
}

PICKBED_TWO_WIDTHS void FillSurvival(RowConstants c, const uint8_t* is_edge, int n,
                                     float* survival) {
  for (int x = 0; x < n; ++x) survival[x] = c.kept * (is_edge[x] ? c.kept_at_edge : 1.0f);
}

// Luma by Rec. 601 in 8 bits.
PICKBED_TWO_WIDTHS void ThinByLuma(const Rgb8* color, const float* luma_survival, int n,
                                   float* __restrict survival) {
  for (int x = 0; x < n; ++x) {
    const int luma = (77 * color[x].r + 150 * color[x].g + 29 * color[x].b + 128) >> 8;
    survival[x] *= luma_survival[luma];
  }
}

PICKBED_TWO_WIDTHS void FillSlant(RowConstants c, const float* slant_rad, const float* depth_m,
                                  int n, float* survival, float* ratio, float* sigma_m) {
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

// Depth a little aside, between pixels: bilinear on a surface, nearest where the four pixels around
// are of two surfaces, since a reading between them would be of neither. For images of at least 2
// x 2.
PICKBED_TWO_WIDTHS void LookAside(RowConstants c, const float* depth_m, int width, int height,
                                  int y, const float* aside, const float* below,
                                  const float* slant_ratio, float* __restrict seen_m) {
  const auto u_max = static_cast<float>(width - 1), v_max = static_cast<float>(height - 1);
  for (int x = 0; x < width; ++x) {
    const float sigma_px = c.lateral_px + c.lateral_slant_px * slant_ratio[x];
    const float u = std::min(std::max(static_cast<float>(x) + sigma_px * aside[x], 0.0f), u_max);
    const float v = std::min(std::max(static_cast<float>(y) + sigma_px * below[x], 0.0f), v_max);
    const int left = std::min(static_cast<int>(u), width - 2);
    const int top = std::min(static_cast<int>(v), height - 2);
    const float a = u - static_cast<float>(left), b = v - static_cast<float>(top);
    const int place = top * width + left;
    const float z00 = depth_m[place], z10 = depth_m[place + 1];
    const float z01 = depth_m[place + width], z11 = depth_m[place + width + 1];
    const float low = std::min(std::min(z00, z10), std::min(z01, z11));
    const float high = std::max(std::max(z00, z10), std::max(z01, z11));
    const float nearest = b < 0.5f ? (a < 0.5f ? z00 : z10) : (a < 0.5f ? z01 : z11);
    const float between = (1 - b) * ((1 - a) * z00 + a * z10) + b * ((1 - a) * z01 + a * z11);
    seen_m[x] = high - low > c.edge_step_m ? nearest : between;
  }
}

// Rounds halves to even, for |value| < 2^22.
inline float RoundToWhole(float value) {
  constexpr float kShift = 12582912.0f;  // 1.5 * 2^23: beyond it floats have no fraction
  return (value + kShift) - kShift;
}

PICKBED_TWO_WIDTHS void Read(RowConstants c, const float* ideal_m, const RowState& row, int n,
                             float* __restrict out_m) {
  const float* seen_m = row.seen_m.data();
  const float* along = row.along.data();
  const float* slant_sigma_m = row.slant_sigma_m.data();
  const float* loss = row.loss.data();
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
    const float kept = loss[x] < survival[x] ? in_range : 0.0f;
    out_m[x] = std::min(ideal_m[x], seen) > 0 ? kept : 0.0f;
  }
}

class NoiseMaker {
 public:
  NoiseMaker(const IdealView& view, const SensorProfile& profile, uint64_t key);
  Image<float> Make();

 private:
  void FindChances(int y);
  void LookAt(int y);
  void MixFlyingPixels(int y);

  const Image<float>& depth_m_;
  const Image<Rgb8>* color_;
  const uint64_t key_;
  const bool needs_slant_, needs_edges_, needs_luma_, needs_shadow_, needs_jitter_;
  const std::array<float, 256> luma_survival_;
  const RowConstants constants_;
  RowState row_;
  SlantRows slants_;
  ShadowRows shadows_;
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
      luma_survival_(LumaTable(p)),
      constants_(p, view.intrinsics.fx),
      row_(depth_m_.width()),
      slants_(depth_m_, view.intrinsics),
      shadows_(depth_m_.width(), view.intrinsics.fx, p.baseline_m, constants_.edge_step_m) {}

void NoiseMaker::FindChances(int y) {
  const int width = depth_m_.width();
  if (needs_edges_) EdgeRow(depth_m_, y, constants_.edge_step_m, row_.is_edge.data());
  if (needs_shadow_) shadows_.Row(depth_m_.row(y), row_.is_shadow.data());
  FillSurvival(constants_, row_.is_edge.data(), width, row_.survival.data());
  if (needs_slant_) {
    FillSlant(constants_, slants_.Row(y), depth_m_.row(y), width, row_.survival.data(),
              row_.slant_ratio.data(), row_.slant_sigma_m.data());
  }
  if (needs_shadow_) {
    for (int x = 0; x < width; ++x) row_.survival[x] *= row_.is_shadow[x] ? 0.0f : 1.0f;
  }
  if (needs_luma_) {
    ThinByLuma(color_->row(y), luma_survival_.data(), width, row_.survival.data());
  }
}

void NoiseMaker::MixFlyingPixels(int y) {
  for (int x = 0; x < depth_m_.width(); ++x) {
    if (!row_.is_edge[x] || !(row_.flying[x] < constants_.flying_share)) continue;
    const float z = depth_m_(x, y);
    // Given that it flies, the decision over the share is uniform once more.
    const float mix = row_.flying[x] / constants_.flying_share;
    row_.seen_m[x] = z + mix * (OtherSurface(depth_m_, x, y) - z);
  }
}

void NoiseMaker::LookAt(int y) {
  if (needs_jitter_) {
    LookAside(constants_, depth_m_.data(), depth_m_.width(), depth_m_.height(), y,
              row_.aside.data(), row_.below.data(), row_.slant_ratio.data(), row_.seen_m.data());
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
    DrawNumbers(place, width, GaussTable().data(), row_);
    FindChances(y);
    LookAt(y);
    Read(constants_, depth_m_.row(y), row_, width, out.row(y));
  }
  return out;
}

std::string SizeText(int width, int height) { return fmt::format("{} x {}", width, height); }

}  // namespace

Image<float> ApplySensorNoise(const IdealView& view, const SensorProfile& profile, Rng& rng) {
  const std::string size = SizeText(view.depth_m.width(), view.depth_m.height());
  const std::string of_camera = SizeText(view.intrinsics.width, view.intrinsics.height);
  CheckInput(size == of_camera,
             fmt::format("a depth image of {} px, but a camera of {} px", size, of_camera));
  if (view.color && !view.color->empty()) {
    const std::string of_color = SizeText(view.color->width(), view.color->height());
    CheckInput(size == of_color,
               fmt::format("a depth image of {} px, but a colour image of {} px", size, of_color));
  }
  const uint64_t key = rng.Next();
  if (ChangesNothing(profile)) return view.depth_m;
  return NoiseMaker(view, profile, key).Make();
}

}  // namespace pickbed
