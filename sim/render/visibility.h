#pragma once

// Visible fractions of instances in an image.

#include <span>
#include <vector>

#include "sim/render/renderer.h"

namespace pickbed::sim {

// Returns for each instance its pixels in `ids` over its unoccluded pixels. The latter are counted
// on a canvas large enough for the whole instance, so pixels outside the image count as occluded
// (BOP's visib_fract). The fraction is 0 if the instance covers no pixel. `ids` is the depth-tested
// id image of `camera`. Ids of instances must be non-zero and unique.
std::vector<double> VisibleFractions(Renderer& renderer, const Camera& camera,
                                     std::span<const RenderInstance> instances,
                                     const Image<uint16_t>& ids);

}  // namespace pickbed::sim
