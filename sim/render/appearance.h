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

// Draw a light, and a surface material.
Light RandomLight(const AppearanceRanges& ranges, Rng& rng);
Material RandomMaterial(const AppearanceRanges& ranges, Rng& rng);
// Fills the pixels without depth with random grey squares. Does nothing if there is no color image.
void PaintBackground(const AppearanceRanges& ranges, Rng& rng, RenderedImage& image);

// Light of a trial, and material of each instance in it. Both are constant during the trial.
Light LampOf(const AppearanceRanges& ranges, uint64_t seed, uint64_t trial);
Material MaterialOf(const AppearanceRanges& ranges, uint64_t seed, uint64_t trial,
                    InstanceId instance);

// Renders color, depth and ids with the light and materials of the trial. The background depends on
// `picture`. The bin has the default material.
RenderedImage RenderWithAppearance(SceneRenderer& renderer, const Scene& scene,
                                   const Camera& camera, const AppearanceRanges& ranges,
                                   uint64_t seed, uint64_t trial, int picture);

}  // namespace pickbed::sim
