#include "eval/bop/instance_masks.h"

#include <algorithm>
#include <cmath>

#include "scenes/camera/footprint.h"

namespace pickbed::eval {
namespace {

constexpr int kMaxCanvas_px = 4096;
constexpr uint8_t kSet = 255;
constexpr std::array<int, 4> kNoBox{-1, -1, -1, -1};

// Smallest view that contains a whole instance, on the pixel grid of the image. Pixel (0, 0) of the
// canvas is pixel (left, top) of the image.
struct Canvas {
  Camera camera;
  int left = 0, top = 0;
};

Canvas CanvasOf(const Camera& camera, const Bounds& bounds_O, const Pose& X_CO) {
  const CameraIntrinsics& k = camera.intrinsics;
  const Footprint footprint = FootprintOf(bounds_O, X_CO, k);
  const Eigen::Vector2d center(0.5 * k.width(), 0.5 * k.height());
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * kMaxCanvas_px);
  Eigen::Vector2d first = center - half, last = center + half;
  if (footprint.in_front) {
    const Eigen::Vector2d low = first, high = last;
    first = footprint.min_px.cwiseMax(low).cwiseMin(high);
    last = footprint.max_px.cwiseMin(high).cwiseMax(low);
  }
  Canvas canvas{camera, static_cast<int>(std::floor(first.x())),
                static_cast<int>(std::floor(first.y()))};
  const int width = std::max(1, static_cast<int>(std::ceil(last.x())) - canvas.left + 1);
  const int height = std::max(1, static_cast<int>(std::ceil(last.y())) - canvas.top + 1);
  canvas.camera.intrinsics = k.Window(canvas.left, canvas.top, width, height);
  return canvas;
}

// Bounding box in px of the pixels added so far.
struct Box {
  int left = 1 << 30, top = 1 << 30, right = -(1 << 30), bottom = -(1 << 30);
  void Add(int u, int v) {
    left = std::min(left, u);
    right = std::max(right, u);
    top = std::min(top, v);
    bottom = std::max(bottom, v);
  }
  std::array<int, 4> ToBop() const { return {left, top, right - left, bottom - top}; }
};

InstanceMasks MasksOfOne(const Image<float>& unoccluded_m, const Canvas& canvas, uint16_t id,
                         const Image<uint16_t>& ids, const Image<uint16_t>& depth) {
  InstanceMasks out;
  out.mask = Image<uint8_t>(ids.width(), ids.height());
  out.mask_visib = Image<uint8_t>(ids.width(), ids.height());
  Box whole, seen;
  int valid = 0;
  for (int y = 0; y < unoccluded_m.height(); ++y) {
    for (int x = 0; x < unoccluded_m.width(); ++x) {
      const int u = x + canvas.left, v = y + canvas.top;
      const bool inside = ids.Contains(u, v);
      const bool visible = inside && ids(u, v) == id;
      // A pixel on the silhouette's edge may be set in only one of the two renderings.
      if (unoccluded_m(x, y) <= 0 && !visible) continue;
      ++out.info.px_count_all;
      whole.Add(u, v);
      if (!inside) continue;
      out.mask(u, v) = kSet;
      valid += depth(u, v) > 0;
      if (!visible) continue;
      out.mask_visib(u, v) = kSet;
      ++out.info.px_count_visib;
      seen.Add(u, v);
    }
  }
  out.info.px_count_valid = valid;
  const bool any = out.info.px_count_visib > 0;
  if (any) {
    out.info.visib_fract = static_cast<double>(out.info.px_count_visib) / out.info.px_count_all;
  }
  out.info.bbox_obj = any ? whole.ToBop() : kNoBox;
  out.info.bbox_visib = any ? seen.ToBop() : kNoBox;
  return out;
}

}  // namespace

std::vector<InstanceMasks> MasksOf(Renderer& renderer, const Camera& camera,
                                   std::span<const RenderInstance> instances,
                                   const Image<uint16_t>& ids, const Image<uint16_t>& depth) {
  const Pose X_CW = camera.X_CW();
  std::vector<Canvas> canvases;
  std::vector<Camera> cameras;
  for (const RenderInstance& instance : instances) {
    canvases.push_back(
        CanvasOf(camera, renderer.MeshBoundsOf(instance.mesh), X_CW * instance.X_WO));
    cameras.push_back(canvases.back().camera);
  }
  const std::vector<RenderedImage> unoccluded = renderer.RenderEachDepth(cameras, instances);
  std::vector<InstanceMasks> masks;
  for (size_t i = 0; i < instances.size(); ++i) {
    masks.push_back(MasksOfOne(unoccluded[i].depth_m, canvases[i], instances[i].id, ids, depth));
  }
  return masks;
}

}  // namespace pickbed::eval
