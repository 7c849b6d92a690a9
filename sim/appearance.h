#pragma once

// Draws how scenes look from scenes/appearance_ranges.h. The same numbers from the Rng give the
// same looks.

#include "scenes/appearance_ranges.h"
#include "scenes/image.h"
#include "scenes/random.h"
#include "scenes/scene.h"
#include "sim/renderer.h"

namespace pickbed {

Light RandomLight(const AppearanceRanges& ranges, Rng& rng);
Material RandomMaterial(const AppearanceRanges& ranges, Rng& rng);
// Colours the pixels without depth in random squares.
void PaintBackground(const AppearanceRanges& ranges, Rng& rng, RenderedImage& image);

// The lamp of a trial and the material of each instance in it: they stay while parts are picked.
Light LampOf(const AppearanceRanges& ranges, uint64_t seed, uint64_t trial);
Material MaterialOf(const AppearanceRanges& ranges, uint64_t seed, uint64_t trial, int instance);

// Colour, depth and ids of the scene with the looks of its trial; the background is drawn anew for
// each `picture`. The bin has its plain material.
RenderedImage RenderWithLooks(SceneRenderer& renderer, const Scene& scene, const Camera& camera,
                              const AppearanceRanges& ranges, uint64_t seed, uint64_t trial,
                              int picture);

}  // namespace pickbed
