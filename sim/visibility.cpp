#include "sim/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pickbed {
namespace {

// A camera at the same place whose image holds all of the instance. It is shifted by whole pixels,
// so that the instance covers the same ones. Only what reaches behind the camera is cut, at
// `kMaxCanvas_px` around the image's middle.
constexpr int kMaxCanvas_px = 4096;

Camera CanvasFor(const Camera& camera, const Bounds& bounds_O, const Pose& X_CO) {
  const CameraIntrinsics& k = camera.intrinsics;
  Eigen::Vector2d min_px = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d max_px = -min_px;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_O((corner & 1 ? bounds_O.max : bounds_O.min).x(),
                              (corner & 2 ? bounds_O.max : bounds_O.min).y(),
                              (corner & 4 ? bounds_O.max : bounds_O.min).z());
    const Eigen::Vector3d p_C = X_CO * p_O;
    if (p_C.z() <= 0) {
      min_px.setConstant(-kMaxCanvas_px);
      max_px.setConstant(kMaxCanvas_px);
      break;
    }
    min_px = min_px.cwiseMin(Project(k, p_C));
    max_px = max_px.cwiseMax(Project(k, p_C));
  }
  const Eigen::Vector2d middle(0.5 * k.width, 0.5 * k.height);
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * kMaxCanvas_px);
  min_px = min_px.cwiseMax(middle - half);
  max_px = max_px.cwiseMin(middle + half);
  Camera canvas = camera;
  const int left = static_cast<int>(std::floor(min_px.x()));
  const int top = static_cast<int>(std::floor(min_px.y()));
  canvas.intrinsics.cx -= left;
  canvas.intrinsics.cy -= top;
  canvas.intrinsics.width = std::max(1, static_cast<int>(std::ceil(max_px.x())) - left + 1);
  canvas.intrinsics.height = std::max(1, static_cast<int>(std::ceil(max_px.y())) - top + 1);
  return canvas;
}

}  // namespace

std::vector<double> VisibleFractions(Renderer& renderer, const Camera& camera,
                                     std::span<const RenderInstance> instances,
                                     const Image<uint16_t>& ids) {
  std::vector<int> seen(std::numeric_limits<uint16_t>::max() + 1, 0);
  for (const uint16_t id : ids.pixels()) ++seen[id];

  std::vector<Camera> canvases;
  canvases.reserve(instances.size());
  const Pose X_CW = camera.X_WC.inverse();
  for (const RenderInstance& instance : instances) {
    canvases.push_back(
        CanvasFor(camera, renderer.MeshBoundsOf(instance.mesh), X_CW * instance.X_WO));
  }
  const std::vector<int> whole = renderer.CountEach(canvases, instances);
  std::vector<double> fractions(instances.size(), 0.0);
  for (size_t i = 0; i < instances.size(); ++i) {
    if (whole[i] > 0) {
      // A pixel on the very edge may round to either side in the two pictures.
      fractions[i] = std::min(1.0, static_cast<double>(seen[instances[i].id]) / whole[i]);
    }
  }
  return fractions;
}

}  // namespace pickbed
