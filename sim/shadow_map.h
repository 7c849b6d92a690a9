#pragma once

// What the lamp sees, as a texture of depths that tells the renderer what lies in shadow. Private
// to sim's .cpp files, see sim/gl_functions.h. Every call needs the context to be current.

#include <span>

#include "sim/gl_drawer.h"
#include "sim/renderer.h"

namespace pickbed {

class ShadowMap {
 public:
  // Draws all instances as seen from the light. Returns false, and draws nothing, when there is
  // nothing to cast a shadow.
  bool Draw(const GlFunctions& gl, GlDrawer& drawer, std::span<const RenderInstance> instances,
            const Light& light);
  // Adds to `setup` what it takes to look it up from a camera.
  void AddTo(DrawSetup& setup, const Pose& X_CW) const;
  void Delete(const GlFunctions& gl);

 private:
  GLuint framebuffer_ = 0;
  GLuint texture_ = 0;
  Pose X_WL_ = Pose::Identity();  // L: the lamp as a camera
  double focal_ = 1;              // half the map's side over the tangent of half its angle
  double near_m_ = 0, far_m_ = 1;
  double blur_ = 0;      // half width of the filter, in texture coordinates
  double offset_m_ = 0;  // lookups start this far above the surface
};

}  // namespace pickbed
