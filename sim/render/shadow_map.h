#pragma once

// Shadow map: a depth texture as seen from the light, used to find shadowed pixels. Private to .cpp
// files of sim, see sim/render/gl_functions.h. The context must be current in every call.

#include <span>

#include "sim/render/gl_drawer.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

class ShadowMap {
 public:
  // Draws all instances as seen from the light. Returns false and draws nothing if there are no
  // instances or the light is too near to their center.
  bool Draw(const GlFunctions& gl, GlDrawer& drawer, std::span<const RenderInstance> instances,
            const Light& light);
  // Adds the shadow map's texture and transform for a camera to `setup`.
  void AddTo(DrawSetup& setup, const Pose& X_CW) const;
  void Delete(const GlFunctions& gl);

 private:
  GLuint framebuffer_ = 0;
  GLuint texture_ = 0;
  Pose X_WL_ = Pose::Identity();  // L = frame of the light as a camera
  double focal_ = 1;              // 1 / tangent of half the map's field of view
  double near_m_ = 0, far_m_ = 1;
  double blur_ = 0;      // half width of the filter, in texture coordinates
  double offset_m_ = 0;  // lookups start this far above the surface
};

}  // namespace pickbed::sim
