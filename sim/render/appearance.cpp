#include "sim/render/appearance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/ids_format.h"

namespace pickbed::sim {
namespace {

double Sample(const Span& span, Rng& rng) { return rng.Uniform(span.min, span.max); }

}  // namespace

Light RandomLight(const AppearanceRanges& ranges, Rng& rng) {
  Light light;
  light.position_W.x() = Sample(ranges.lamp_x_m, rng);
  light.position_W.y() = Sample(ranges.lamp_y_m, rng);
  light.position_W.z() = Sample(ranges.lamp_z_m, rng);
  light.ambient = Sample(ranges.ambient, rng);
  light.diffuse = 1 - light.ambient;
  light.shadow = rng.Uniform() < ranges.shadow_share;
  light.shadow_softness_m = Sample(ranges.shadow_softness_m, rng);
  return light;
}

Material RandomMaterial(const AppearanceRanges& ranges, Rng& rng) {
  Material material;
  for (int channel = 0; channel < 3; ++channel) material.tint[channel] = Sample(ranges.tint, rng);
  material.gloss = Sample(ranges.gloss, rng);
  material.grain = Sample(ranges.grain, rng);
  // Without a pattern the cell size keeps its default, so that plain materials compare equal.
  const double cells_pm = Sample(ranges.grain_cells_pm, rng);
  if (material.grain > 0) material.grain_cells_pm = cells_pm;
  return material;
}

void PaintBackground(const AppearanceRanges& ranges, Rng& rng, RenderedImage& image) {
  if (image.color.empty()) return;
  const int cell_px = std::max(1, static_cast<int>(Sample(ranges.background_cell_px, rng)));
  const int across = (image.color.width() + cell_px - 1) / cell_px;
  std::vector<uint8_t> greys(across);
  for (int y = 0; y < image.color.height(); ++y) {
    if (y % cell_px == 0) {
      for (uint8_t& grey : greys) {
        grey = static_cast<uint8_t>(std::lround(255 * Sample(ranges.background, rng)));
      }
    }
    for (int x = 0; x < image.color.width(); ++x) {
      if (image.depth_m(x, y) > 0) continue;
      const uint8_t grey = greys[x / cell_px];
      image.color(x, y) = {grey, grey, grey};
    }
  }
}

Light LampOf(const AppearanceRanges& ranges, uint64_t seed, BinIndex bin_index) {
  Rng rng = Rng::Derive(seed, bin_index, "looks/lamp");
  return RandomLight(ranges, rng);
}

Material MaterialOf(const AppearanceRanges& ranges, uint64_t seed, BinIndex bin_index,
                    InstanceId instance) {
  Rng rng = Rng::Derive(seed, bin_index, fmt::format("looks/part/{}", instance));
  return RandomMaterial(ranges, rng);
}

RenderedImage RenderWithAppearance(SceneRenderer& renderer, const Scene& scene,
                                   const Camera& camera, const AppearanceRanges& ranges,
                                   uint64_t seed, BinIndex bin_index, int picture) {
  std::vector<RenderInstance> instances = renderer.InstancesOf(scene);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    instances[i].material = MaterialOf(ranges, seed, bin_index, scene.objects[i].instance);
  }
  RenderedImage image =
      renderer.renderer().Render(camera, instances, LampOf(ranges, seed, bin_index));
  Rng rng = Rng::Derive(seed, bin_index, fmt::format("looks/background/{}", picture));
  PaintBackground(ranges, rng, image);
  return image;
}

}  // namespace pickbed::sim
