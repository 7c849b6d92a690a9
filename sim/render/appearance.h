#pragma once

// Random lights, materials and backgrounds, drawn from the ranges of
// scenes/scenario/appearance_ranges.h. The same Rng state gives the same result.

#include "scenes/base/ids.h"
#include "scenes/base/random.h"
#include "scenes/image/image.h"
#include "scenes/scenario/appearance_ranges.h"
#include "scenes/scene.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// Draws a light.
Light RandomLight(const AppearanceRanges& ranges, Rng& rng);
// Draws a surface material.
Material RandomMaterial(const AppearanceRanges& ranges, Rng& rng);
// Fills the pixels without depth with random grey squares. Does nothing if there is no color image.
void PaintBackground(const AppearanceRanges& ranges, Rng& rng, RenderedImage& image);

// Returns the light of a bin. It is constant during a trial.
Light LampOf(const AppearanceRanges& ranges, uint64_t seed, BinIndex bin_index);
// Returns the material of an instance in a bin. It is constant during a trial.
Material MaterialOf(const AppearanceRanges& ranges, uint64_t seed, BinIndex bin_index,
                    InstanceId instance);

// Renders color, depth and ids with the light and materials of the bin. The background depends on
// `picture`. The bin has the default material.
RenderedImage RenderWithAppearance(SceneRenderer& renderer, const Scene& scene,
                                   const Camera& camera, const AppearanceRanges& ranges,
                                   uint64_t seed, BinIndex bin_index, int picture);

}  // namespace pickbed::sim
