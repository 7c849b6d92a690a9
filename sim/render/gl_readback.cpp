#include "sim/render/gl_readback.h"

#include <algorithm>
#include <cstring>

namespace pickbed::sim {
namespace {

void PackVectors(const float* from, Eigen::Vector3f* to, int count) {
  for (int i = 0; i < count; ++i) to[i] = {from[4 * i], from[4 * i + 1], from[4 * i + 2]};
}

size_t Area(const ImageBox& box) { return static_cast<size_t>(box.width) * box.height; }

}  // namespace

// Converts four pixels at a time as whole words. Little-endian: red is the lowest byte.
void PackRgb(const uint32_t* from, Rgb8* to, int count) {
  static_assert(sizeof(Rgb8) == 3);
  int i = 0;
  for (; i + 4 <= count; i += 4) {
    uint64_t low, high;
    std::memcpy(&low, from + i, sizeof(low));
    std::memcpy(&high, from + i + 2, sizeof(high));
    const uint64_t first = (low & 0xffffff) | (low >> 8 & 0xffffff000000) | high << 48;
    const auto second = static_cast<uint32_t>((high >> 16 & 0xff) | (high >> 24 & 0xffffff00));
    char* out = reinterpret_cast<char*>(to + i);
    std::memcpy(out, &first, sizeof(first));
    std::memcpy(out + sizeof(first), &second, sizeof(second));
  }
  for (; i < count; ++i) {
    to[i] = {static_cast<uint8_t>(from[i]), static_cast<uint8_t>(from[i] >> 8),
             static_cast<uint8_t>(from[i] >> 16)};
  }
}

RenderedImage Readback::EmptyImage(GlOutputs outputs, int width, int height) {
  RenderedImage out;
  const Eigen::Vector3f zero = Eigen::Vector3f::Zero();
  out.depth_m = Image<float>(width, height);
  if (outputs & OutputBit(kIdOutput)) out.ids = Image<uint16_t>(width, height);
  if (outputs & OutputBit(kColorOutput)) out.color = Image<Rgb8>(width, height);
  if (outputs & OutputBit(kNormalOutput)) {
    out.normals_C = Image<Eigen::Vector3f>(width, height, zero);
  }
  if (outputs & OutputBit(kCoordinateOutput)) {
    out.coordinates_O = Image<Eigen::Vector3f>(width, height, zero);
  }
  return out;
}

RenderedImage Readback::ReadImage(const GlFunctions& gl, GlOutputs outputs, int width, int height,
                                  const ImageBox& box) {
  RenderedImage out = EmptyImage(outputs, width, height);
  gl.ReadBuffer(AttachmentOf(kDepthOutput));
  gl.PixelStorei(GL_PACK_ROW_LENGTH, width);
  gl.ReadPixels(0, 0, box.width, box.height, GL_RED, GL_FLOAT, out.depth_m.row(box.y) + box.x);
  gl.PixelStorei(GL_PACK_ROW_LENGTH, 0);
  const auto each_row = [&](auto& image, const auto* pixels, size_t stride, auto pack) {
    for (int y = 0; y < box.height; ++y) {
      pack(pixels + stride * y * box.width, image.row(box.y + y) + box.x, box.width);
    }
  };
  if (outputs & OutputBit(kIdOutput)) {
    ids_.resize(Area(box));
    gl.ReadBuffer(AttachmentOf(kIdOutput));
    gl.ReadPixels(0, 0, box.width, box.height, GL_RED_INTEGER, GL_UNSIGNED_INT, ids_.data());
    each_row(out.ids, ids_.data(), 1, [](const uint32_t* from, uint16_t* to, int count) {
      for (int i = 0; i < count; ++i) to[i] = static_cast<uint16_t>(from[i]);
    });
  }
  if (outputs & OutputBit(kColorOutput)) {
    rgba_.resize(Area(box));
    gl.ReadBuffer(AttachmentOf(kColorOutput));
    gl.ReadPixels(0, 0, box.width, box.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba_.data());
    each_row(out.color, rgba_.data(), 1, PackRgb);
  }
  const auto read_vectors = [&](GlOutput output, Image<Eigen::Vector3f>& image) {
    if (!(outputs & OutputBit(output))) return;
    floats_.resize(4 * Area(box));
    gl.ReadBuffer(AttachmentOf(output));
    gl.ReadPixels(0, 0, box.width, box.height, GL_RGBA, GL_FLOAT, floats_.data());
    each_row(image, floats_.data(), 4, PackVectors);
  };
  read_vectors(kNormalOutput, out.normals_C);
  read_vectors(kCoordinateOutput, out.coordinates_O);
  return out;
}

void Readback::FillIds(RenderedImage& image, const ImageBox& box, uint16_t id) {
  image.ids = Image<uint16_t>(image.depth_m.width(), image.depth_m.height());
  for (int y = box.y; y < box.y + box.height; ++y) {
    const float* depth_m = image.depth_m.row(y);
    uint16_t* ids = image.ids.row(y);
    for (int x = box.x; x < box.x + box.width; ++x) ids[x] = depth_m[x] > 0 ? id : 0;
  }
}

void Readback::ReadPage(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs) {
  const size_t pixels = static_cast<size_t>(target.width) * target.height;
  page_width_ = target.width;
  floats_.resize(pixels);
  gl.ReadBuffer(AttachmentOf(kDepthOutput));
  gl.ReadPixels(0, 0, target.width, target.height, GL_RED, GL_FLOAT, floats_.data());
  page_has_color_ = outputs & OutputBit(kColorOutput);
  if (!page_has_color_) return;
  rgba_.resize(pixels);
  gl.ReadBuffer(AttachmentOf(kColorOutput));
  gl.ReadPixels(0, 0, target.width, target.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba_.data());
}

RenderedImage Readback::CropPage(const ImageBox& box, uint16_t id) const {
  RenderedImage out;
  out.depth_m = Image<float>(box.width, box.height);
  out.ids = Image<uint16_t>(box.width, box.height);
  if (page_has_color_) out.color = Image<Rgb8>(box.width, box.height);
  for (int y = 0; y < box.height; ++y) {
    const size_t begin = static_cast<size_t>(box.y + y) * page_width_ + box.x;
    const float* depth_m = floats_.data() + begin;
    std::copy_n(depth_m, box.width, out.depth_m.row(y));
    uint16_t* ids = out.ids.row(y);
    for (int x = 0; x < box.width; ++x) ids[x] = depth_m[x] > 0 ? id : 0;
    if (page_has_color_) PackRgb(rgba_.data() + begin, out.color.row(y), box.width);
  }
  return out;
}

void Readback::ReadCoverage(const GlFunctions& gl, const GlTarget& target) {
  page_width_ = target.width;
  coverage_.resize(static_cast<size_t>(target.width) * target.height);
  gl.ReadBuffer(AttachmentOf(kDepthOutput));
  gl.ReadPixels(0, 0, target.width, target.height, GL_RED, GL_UNSIGNED_BYTE, coverage_.data());
}

int Readback::CountCovered(const ImageBox& box) const {
  int count = 0;
  for (int y = 0; y < box.height; ++y) {
    const uint8_t* row = coverage_.data() + static_cast<size_t>(box.y + y) * page_width_ + box.x;
    for (int x = 0; x < box.width; ++x) count += row[x] >> 7;
  }
  return count;
}

}  // namespace pickbed::sim
