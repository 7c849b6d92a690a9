#pragma once

// Pixels of a framebuffer, read once and cut into images. Private to sim's .cpp files.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/atlas.h"
#include "sim/gl_objects.h"
#include "sim/renderer.h"

namespace pickbed {

// Its memory is kept between readings, since fresh pages of memory cost as much as the copy.
class Readback {
 public:
  void ReadDepth(const GlFunctions& gl, const GlTarget& target);
  void ReadAll(const GlFunctions& gl, const GlTarget& target, bool with_color);

  // The images of a tile of what was read last; colour is empty unless it was read.
  RenderedImage Crop(const AtlasTile& tile, int width, int height) const;
  // Pixels with a depth in a tile.
  int CountCovered(const AtlasTile& tile, int width, int height) const;

 private:
  int width_ = 0;
  bool has_color_ = false;
  std::vector<float> depth_m_;
  std::vector<uint16_t> ids_;
  std::vector<std::array<uint8_t, 4>> rgba_;
};

}  // namespace pickbed
