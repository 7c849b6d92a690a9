#pragma once

// Animated GIF files ("GIF89a", CompuServe, 1990).

#include <span>
#include <string>

#include "eval/layer.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Returns the bytes of a GIF that repeats forever. All frames must have the same size, at most
// 65535 px per side. `frame_s` is the time between frames, rounded to 0.01 s, at least 0.02 s. The
// colors are reduced to 255 for all frames together. A frame holds only what changed. The same
// input gives the same bytes. Throws std::logic_error without frames or for different sizes.
std::string GifBytes(std::span<const Image<Rgb8>> frames, double frame_s);

}  // namespace pickbed::eval
