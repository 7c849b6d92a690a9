#pragma once

// Pixels of a framebuffer, read once and put into images. Private to sim's .cpp files.

#include <cstdint>
#include <vector>

#include "scenes/footprint.h"
#include "sim/gl_targets.h"
#include "sim/renderer.h"

namespace pickbed {

// Rows of three bytes from rows of four. (The driver's own conversion is far slower than copying
// four.)
void PackRgb(const uint32_t* from, Rgb8* to, int count);

// Its memory is kept between readings, since fresh pages of memory cost as much as the copy.
class Readback {
 public:
  // All zero, with the images of these outputs.
  static RenderedImage EmptyImage(GlOutputs outputs, int width, int height);

  // Reads from the target's corner what was drawn there for `box` of a whole image; outside of the
  // box the images are zero.
  RenderedImage ReadImage(const GlFunctions& gl, GlOutputs outputs, int width, int height,
                          const ImageBox& box);

  // Makes the id image of a picture of one instance: `id` wherever there is a depth in the box.
  static void FillIds(RenderedImage& image, const ImageBox& box, uint16_t id);

  // For targets that hold many small pictures: all of depth, and colour.
  void ReadPage(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs);
  // A picture of the page that was read last; `id` stands wherever there is a depth.
  RenderedImage CropPage(const ImageBox& box, uint16_t id) const;

  // For targets of coverage: pixels of a picture that are covered.
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

}  // namespace pickbed
