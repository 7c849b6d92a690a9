#pragma once

// How much of each instance a camera sees.

#include <span>
#include <vector>

#include "sim/renderer.h"

namespace pickbed {

// Of each instance: its pixels in `ids` over its pixels alone on a canvas large enough to hold all
// of it (BOP's visib_fract; pixels outside the image count as hidden). 0 where it covers no pixel.
// `ids` is the depth-tested id image that `camera` saw; ids of instances must be non-zero and
// differ.
std::vector<double> VisibleFractions(Renderer& renderer, const Camera& camera,
                                     std::span<const RenderInstance> instances,
                                     const Image<uint16_t>& ids);

}  // namespace pickbed
