#pragma once

// Copies framebuffer pixels into images. Private to .cpp files of sim.

#include <cstdint>
#include <vector>

#include "scenes/camera/footprint.h"
#include "sim/render/gl_targets.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// Converts RGBA pixels to RGB. The driver's own conversion is far slower than reading four bytes.
void PackRgb(const uint32_t* from, Rgb8* to, int count);

// Reads framebuffers. It keeps its memory between readings, because fresh memory pages cost as much
// as the copy.
class Readback {
 public:
  // Returns images of these outputs, filled with zeros.
  static RenderedImage EmptyImage(GlOutputs outputs, int width, int height);

  // Reads the pixels of `box` from the target's corner, where they were drawn. The images are zero
  // outside the box.
  RenderedImage ReadImage(const GlFunctions& gl, GlOutputs outputs, int width, int height,
                          const ImageBox& box);

  // Creates the id image of a single instance: `id` at each pixel of the box with a depth.
  static void FillIds(RenderedImage& image, const ImageBox& box, uint16_t id);

  // Reads depth and color of a target with many small images (an atlas page).
  void ReadPage(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs);
  // Returns one image of the last page. Its ids are `id` at each pixel with a depth.
  RenderedImage CropPage(const ImageBox& box, uint16_t id) const;

  // Reads a coverage target; CountCovered() then returns the number of covered pixels of one image.
  void ReadCoverage(const GlFunctions& gl, const GlTarget& target);
  int CountCovered(const ImageBox& box) const;

 private:
  int page_width_ = 0;
  bool page_has_color_ = false;
  std::vector<float> floats_;
  std::vector<uint32_t> ids_;
  std::vector<uint32_t> rgba_;
  std::vector<uint8_t> coverage_;
};

}  // namespace pickbed::sim
