#include "sim/appearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/check.h"

namespace pickbed {
namespace {

double Draw(const Span& span, Rng& rng) { return rng.Uniform(span.min, span.max); }

void CheckSpan(const char* name, const Span& span, double low, double high) {
  CheckInput(span.min >= low && span.max >= span.min && span.max <= high,
             fmt::format("appearance {} from {} to {}: need {} <= min <= max <= {}", name, span.min,
                         span.max, low, high));
}

}  // namespace

void AppearanceRanges::Validate() const {
  constexpr double kFar_m = 100;
  CheckSpan("lamp_x_m", lamp_x_m, -kFar_m, kFar_m);
  CheckSpan("lamp_y_m", lamp_y_m, -kFar_m, kFar_m);
  CheckSpan("lamp_z_m", lamp_z_m, -kFar_m, kFar_m);
  CheckSpan("ambient", ambient, 0, 1);
  CheckSpan("shadow_share", {shadow_share, shadow_share}, 0, 1);
  CheckSpan("shadow_softness_m", shadow_softness_m, 0, 0.1);
  CheckSpan("tint", tint, 0, 1);
  CheckSpan("gloss", gloss, 0, 1);
  CheckSpan("grain", grain, 0, 1);
  CheckSpan("grain_cells_pm", grain_cells_pm, 1, 1e5);
  CheckSpan("background", background, 0, 1);
  CheckSpan("background_cell_px", background_cell_px, 1, 1e4);
}

AppearanceRanges WideAppearance() {
  AppearanceRanges ranges;
  ranges.ambient = {0.15, 0.6};
  ranges.shadow_share = 0.7;
  ranges.tint = {0.4, 1};
  ranges.gloss = {0, 0.6};
  ranges.grain = {0, 0.5};
  ranges.background = {0, 1};
  return ranges;
}

Light RandomLight(const AppearanceRanges& ranges, Rng& rng) {
  Light light;
  light.position_W.x() = Draw(ranges.lamp_x_m, rng);
  light.position_W.y() = Draw(ranges.lamp_y_m, rng);
  light.position_W.z() = Draw(ranges.lamp_z_m, rng);
  light.ambient = Draw(ranges.ambient, rng);
  light.diffuse = 1 - light.ambient;
  light.shadow = rng.Uniform() < ranges.shadow_share;
  light.shadow_softness_m = Draw(ranges.shadow_softness_m, rng);
  return light;
}

Material RandomMaterial(const AppearanceRanges& ranges, Rng& rng) {
  Material material;
  for (int channel = 0; channel < 3; ++channel) material.tint[channel] = Draw(ranges.tint, rng);
  material.gloss = Draw(ranges.gloss, rng);
  material.grain = Draw(ranges.grain, rng);
  // Without a pattern its size is left alone, so that plain materials stay equal.
  const double cells_pm = Draw(ranges.grain_cells_pm, rng);
  if (material.grain > 0) material.grain_cells_pm = cells_pm;
  return material;
}

void PaintBackground(const AppearanceRanges& ranges, Rng& rng, RenderedImage& image) {
  if (image.color.empty()) return;
  const int cell_px = std::max(1, static_cast<int>(Draw(ranges.background_cell_px, rng)));
  const int across = (image.color.width() + cell_px - 1) / cell_px;
  std::vector<uint8_t> greys(across);
  for (int y = 0; y < image.color.height(); ++y) {
    if (y % cell_px == 0) {
      for (uint8_t& grey : greys) {
        grey = static_cast<uint8_t>(std::lround(255 * Draw(ranges.background, rng)));
      }
    }
    for (int x = 0; x < image.color.width(); ++x) {
      if (image.depth_m(x, y) > 0) continue;
      const uint8_t grey = greys[x / cell_px];
      image.color(x, y) = {grey, grey, grey};
    }
  }
}

}  // namespace pickbed
