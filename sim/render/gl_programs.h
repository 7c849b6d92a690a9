#pragma once

// Shader programs of the renderer. Private to .cpp files of sim, see sim/render/gl_functions.h.

#include <map>

#include "sim/render/gl_functions.h"

namespace pickbed::sim {

// Switches of sim/render/shaders.h, as bits.
enum ShaderSwitch : unsigned {
  kColorSwitch = 1,
  kIdsSwitch = 2,
  kNormalsSwitch = 4,
  kCoordinatesSwitch = 8,
  kCoverageSwitch = 16,
  kTextureSwitch = 32,
  kFlatSwitch = 64,
  kMaterialSwitch = 128,
  kShadowSwitch = 256,
  kShadowMapSwitch = 512,
  kVertexColorSwitch = 1024,
};

struct GlProgram {
  GLuint program = 0;
  GLint light_C = -1;
  GLint ambient_diffuse = -1;
  GLint color = -1;
  GLint shadow_from_C = -1;
  GLint shadow_blur = -1;
};

// Cache of programs by their switches. A program is created at its first use. The owner's context
// must be current in every call.
class GlPrograms {
 public:
  // Throws std::logic_error with the compiler's log.
  const GlProgram& Of(const GlFunctions& gl, unsigned switches);
  void DeleteAll(const GlFunctions& gl);

 private:
  std::map<unsigned, GlProgram> programs_;
};

}  // namespace pickbed::sim
