#include "sim/gl_attributes.h"

namespace pickbed {

// Clip coordinates of OpenGL. Pixel centres are whole numbers here and halves in OpenGL:
// u + 0.5 = (clip x / clip w + 1) / 2 * width.
InstanceAttributes AttributesOf(const Pose& X_CO, const RenderInstance& instance,
                                const CameraIntrinsics& k, const DepthRange& range,
                                const Eigen::Vector2i& corner, int viewport_width,
                                int viewport_height) {
  InstanceAttributes out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out.X_CO_rows[4 * row + column] = static_cast<float>(X_CO(row, column));
    }
  }
  out.xy_projection = {static_cast<float>(2 * k.fx / viewport_width),
                       static_cast<float>(2 * (k.cx + corner.x() + 0.5) / viewport_width - 1),
                       static_cast<float>(2 * k.fy / viewport_height),
                       static_cast<float>(2 * (k.cy + corner.y() + 0.5) / viewport_height - 1)};
  const double depth = range.far_m - range.near_m;
  out.z_projection = {static_cast<float>((range.far_m + range.near_m) / depth),
                      static_cast<float>(-2 * range.far_m * range.near_m / depth)};
  const Material& m = instance.material;
  out.tint_gloss = {static_cast<float>(m.tint.x()), static_cast<float>(m.tint.y()),
                    static_cast<float>(m.tint.z()), static_cast<float>(m.gloss)};
  out.grain = {static_cast<float>(m.grain), static_cast<float>(m.grain_cells_pm)};
  out.id = instance.id;
  return out;
}

}  // namespace pickbed
