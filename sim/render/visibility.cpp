#include "sim/render/visibility.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/camera/footprint.h"

namespace pickbed::sim {
namespace {

constexpr int kMaxCanvas_px = 4096;

// Returns a camera at the same place whose image shows the whole instance. The image is shifted by
// whole pixels, so that the same pixels are covered. An instance that extends behind the camera has
// an unbounded image; it is cut to kMaxCanvas_px around the image center.
Camera CanvasFor(const Camera& camera, const Bounds& bounds_O, const Pose& X_CO) {
  const CameraIntrinsics& k = camera.intrinsics;
  const Footprint footprint = FootprintOf(bounds_O, X_CO, k);
  const Eigen::Vector2d center(0.5 * k.width(), 0.5 * k.height());
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * kMaxCanvas_px);
  Eigen::Vector2d min_px = center - half, max_px = center + half;
  if (footprint.in_front) {
    min_px = footprint.min_px.cwiseMax(min_px).cwiseMin(max_px);
    max_px = footprint.max_px.cwiseMin(max_px).cwiseMax(min_px);
  }
  Camera canvas = camera;
  const int left = static_cast<int>(std::floor(min_px.x()));
  const int top = static_cast<int>(std::floor(min_px.y()));
  const int width = std::max(1, static_cast<int>(std::ceil(max_px.x())) - left + 1);
  const int height = std::max(1, static_cast<int>(std::ceil(max_px.y())) - top + 1);
  canvas.intrinsics = k.Window(left, top, width, height);
  return canvas;
}

}  // namespace

std::vector<double> VisibleFractions(Renderer& renderer, const Camera& camera,
                                     std::span<const RenderInstance> instances,
                                     const Image<uint16_t>& ids) {
  std::vector<int> seen(std::numeric_limits<uint16_t>::max() + 1, 0);
  const std::vector<uint16_t>& pixels = ids.pixels();
  // Each iteration counts one run of equal ids.
  for (size_t begin = 0, end = 0; begin < pixels.size(); begin = end) {
    for (end = begin + 1; end < pixels.size() && pixels[end] == pixels[begin];) ++end;
    seen[pixels[begin]] += static_cast<int>(end - begin);
  }

  std::vector<Camera> canvases;
  canvases.reserve(instances.size());
  const Pose X_CW = camera.X_CW();
  for (const RenderInstance& instance : instances) {
    canvases.push_back(
        CanvasFor(camera, renderer.MeshBoundsOf(instance.mesh), X_CW * instance.X_WO));
  }
  const std::vector<int> whole = renderer.CountEach(canvases, instances);
  std::vector<double> fractions(instances.size(), 0.0);
  for (size_t i = 0; i < instances.size(); ++i) {
    if (whole[i] > 0) {
      // A pixel exactly on an edge may be covered in only one of the two images.
      fractions[i] = std::min(1.0, static_cast<double>(seen[instances[i].id]) / whole[i]);
    }
  }
  return fractions;
}

}  // namespace pickbed::sim
