#pragma once

// Framebuffers of the renderer. Private to .cpp files of sim, see sim/render/gl_functions.h. The
// owner's context must be current in every call.

#include <array>
#include <vector>

#include "sim/render/gl_functions.h"

namespace pickbed::sim {

// Outputs of the fragment shader. The values are the locations in sim/render/shaders.h.
enum GlOutput : unsigned {
  kDepthOutput = 0,  // metres, R32F; R8 in a coverage target
  kIdOutput = 1,     // R32UI, because llvmpipe clears 16-bit pixels one by one
  kColorOutput = 2,  // RGBA8
  kNormalOutput = 3,
  kCoordinateOutput = 4,
  kOutputCount = 5,
};
using GlOutputs = unsigned;  // bits 1 << GlOutput
constexpr GlOutputs OutputBit(GlOutput output) { return 1u << output; }
constexpr GLenum AttachmentOf(GlOutput output) { return GL_COLOR_ATTACHMENT0 + output; }

enum class GlTargetKind {
  kImage,           // depth in metres, ids, color, and a depth buffer
  kImageAndExtras,  // also normals and object coordinates (RGBA32F)
  kCoverage,        // one byte per pixel, no depth buffer
};

struct GlTarget {
  GlTargetKind kind = GlTargetKind::kImage;
  int width = 0;
  int height = 0;
  GLuint framebuffer = 0;
  std::vector<GLuint> renderbuffers;
};

// Cache of framebuffers by kind and size, up to a total number of pixels. The least recently used
// one is deleted first.
class GlTargets {
 public:
  // Throws std::runtime_error if the driver refuses the size.
  const GlTarget& Of(const GlFunctions& gl, GlTargetKind kind, int width, int height);
  void DeleteAll(const GlFunctions& gl);

 private:
  std::vector<GlTarget> targets_;
};

// Binds the target, selects its outputs, and clears them to zero (the depth buffer to far).
void BeginTarget(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs);

}  // namespace pickbed::sim
