#pragma once

// Framebuffers of the renderer. Private to sim's .cpp files, see sim/gl_functions.h. Every call
// needs the owner's context to be current.

#include <array>
#include <vector>

#include "sim/gl_functions.h"

namespace pickbed {

// What a fragment shader may write, by its output's location in sim/shaders.h.
enum GlOutput : unsigned {
  kDepthOutput = 0,  // metres, R32F; coverage (R8) in a target of that kind
  kIdOutput = 1,     // R32UI: llvmpipe clears 16-bit pixels one by one
  kColorOutput = 2,  // RGBA8
  kNormalOutput = 3,
  kCoordinateOutput = 4,
  kOutputCount = 5,
};
using GlOutputs = unsigned;  // bit 1 << GlOutput
constexpr GlOutputs OutputBit(GlOutput output) { return 1u << output; }
constexpr GLenum AttachmentOf(GlOutput output) { return GL_COLOR_ATTACHMENT0 + output; }

enum class GlTargetKind {
  kImage,           // depth in metres, ids, colour, and a depth buffer
  kImageAndExtras,  // normals and object coordinates too (RGBA32F)
  kCoverage,        // one byte a pixel and no depth buffer
};

struct GlTarget {
  GlTargetKind kind = GlTargetKind::kImage;
  int width = 0;
  int height = 0;
  GLuint framebuffer = 0;
  std::vector<GLuint> renderbuffers;
};

// Framebuffers by kind and size, kept up to a number of pixels; the least recently used one goes.
class GlTargets {
 public:
  // Throws std::runtime_error when the driver refuses the size.
  const GlTarget& Of(const GlFunctions& gl, GlTargetKind kind, int width, int height);
  void DeleteAll(const GlFunctions& gl);

 private:
  std::vector<GlTarget> targets_;
};

// Binds it, chooses what is drawn, and clears that to zero (far for the depth buffer).
void BeginTarget(const GlFunctions& gl, const GlTarget& target, GlOutputs outputs);

}  // namespace pickbed
