#pragma once

// Shader programs of the renderer. Private to sim's .cpp files, see sim/gl_functions.h.

#include <map>

#include "sim/gl_functions.h"

namespace pickbed {

// Switches of sim/shaders.h, as bits.
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

// Programs by their switches, each made when first asked for. Calls need the owner's context to be
// current.
class GlPrograms {
 public:
  // Throws std::logic_error with the compiler's log.
  const GlProgram& Of(const GlFunctions& gl, unsigned switches);
  void DeleteAll(const GlFunctions& gl);

 private:
  std::map<unsigned, GlProgram> programs_;
};

}  // namespace pickbed
