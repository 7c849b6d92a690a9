#include "eval/cell/visible_size.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pickbed::eval {

double WorkingDistance_m(const Camera& camera, double bin_height_m) {
  return (camera.X_CW() * Eigen::Vector3d(0, 0, bin_height_m / 4)).z();
}

std::string TooSmallText(const ScenarioSpec& spec, const ObjectSet& objects) {
  const Camera camera = CameraOf(spec);
  const double focal_px = std::min(camera.intrinsics.fx(), camera.intrinsics.fy());
  const double distance_m = WorkingDistance_m(camera, spec.bin.inner_size_m.z());
  for (size_t i = 0; i < objects.size(); ++i) {
    if (spec.objects[i].distractor) continue;
    const double diameter_m = objects[i]->diameter_m;
    const double size_px = diameter_m * focal_px / distance_m;
    if (size_px >= kMinVisibleDiameter_px) continue;
    const double near_m = diameter_m * focal_px / kMinVisibleDiameter_px;
    const double sharp_px = kMinVisibleDiameter_px * distance_m / diameter_m;
    return fmt::format(
        "{} = [{:g}, {:g}, {:g}]: object '{}' is {:.0f} px large at a distance of {:.2f} m, but an "
        "estimator needs {:.0f} px; move the camera to a distance of {:.2f} m, or use "
        "camera.focal_px={:.0f} with more pixels",
        spec.At("camera.eye_m"), spec.camera.eye_m.x(), spec.camera.eye_m.y(),
        spec.camera.eye_m.z(), objects[i]->name, size_px, distance_m, kMinVisibleDiameter_px,
        0.01 * std::floor(100 * near_m), std::ceil(sharp_px));
  }
  return {};
}

}  // namespace pickbed::eval
