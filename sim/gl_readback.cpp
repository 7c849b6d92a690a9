#include "sim/gl_readback.h"

#include <algorithm>

namespace pickbed {

void Readback::ReadDepth(const GlFunctions& gl, const GlTarget& target) {
  width_ = target.width;
  depth_m_.resize(static_cast<size_t>(target.width) * target.height);
  gl.ReadBuffer(kDepthAttachment);
  gl.ReadPixels(0, 0, target.width, target.height, GL_RED, GL_FLOAT, depth_m_.data());
}

void Readback::ReadAll(const GlFunctions& gl, const GlTarget& target, bool with_color) {
  ReadDepth(gl, target);
  ids_.resize(depth_m_.size());
  gl.ReadBuffer(kIdAttachment);
  gl.ReadPixels(0, 0, target.width, target.height, GL_RED_INTEGER, GL_UNSIGNED_SHORT, ids_.data());
  has_color_ = with_color;
  if (!with_color) return;
  // The driver's own conversion to three bytes is far slower than copying four.
  rgba_.resize(depth_m_.size());
  gl.ReadBuffer(kColorAttachment);
  gl.ReadPixels(0, 0, target.width, target.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba_.data());
}

RenderedImage Readback::Crop(const AtlasTile& tile, int width, int height) const {
  RenderedImage out;
  out.depth_m = Image<float>(width, height);
  out.ids = Image<uint16_t>(width, height);
  if (has_color_) out.color = Image<Rgb8>(width, height);
  for (int y = 0; y < height; ++y) {
    const size_t begin = static_cast<size_t>(tile.y + y) * width_ + tile.x;
    std::copy_n(depth_m_.data() + begin, width, out.depth_m.row(y));
    std::copy_n(ids_.data() + begin, width, out.ids.row(y));
    if (!has_color_) continue;
    const std::array<uint8_t, 4>* from = rgba_.data() + begin;
    Rgb8* to = out.color.row(y);
    for (int x = 0; x < width; ++x) to[x] = {from[x][0], from[x][1], from[x][2]};
  }
  return out;
}

int Readback::CountCovered(const AtlasTile& tile, int width, int height) const {
  int count = 0;
  for (int y = 0; y < height; ++y) {
    const float* row = depth_m_.data() + static_cast<size_t>(tile.y + y) * width_ + tile.x;
    for (int x = 0; x < width; ++x) count += row[x] > 0;
  }
  return count;
}

}  // namespace pickbed
