#pragma once

// Ground truth of a rendered image for each instance: masks, pixel counts and boxes. The
// definitions are those in BOP's scene_gt_info.json and mask folders. Choices where BOP leaves one:
// - A pixel is visible if the id image shows the instance there. The BOP toolkit has only depth. It
//   takes a pixel as visible up to 15 mm behind the measured surface, and so also counts instances
//   close below another one as visible.
// - px_count_all and bbox_obj cover the whole silhouette, also outside the image. The silhouette is
//   cut to 4096 px around the image center, also for an instance that reaches behind the camera.
// - mask is the silhouette inside the image, also where another instance occludes it. A hidden
//   instance therefore has a mask, and an empty mask_visib.
// - Boxes are x, y, and last minus first column and row, as the toolkit computes them: a single
//   pixel has width 0. Both are -1 -1 -1 -1 for an instance without a visible pixel.

#include <span>
#include <vector>

#include "eval/bop/read_dataset.h"
#include "sim/render/renderer.h"

namespace pickbed::eval {

struct InstanceMasks {
  InstanceInfo info;
  Image<uint8_t> mask, mask_visib;  // 0 or 255
};

// Computes the masks of each instance. `camera` gives X_WC and intrinsics. `ids` is the id image of
// all instances from this camera; the ids must be non-zero and distinct. `depth` has the same size;
// its unit is not used, 0 = no reading. Returns one entry per instance, in the order of
// `instances`.
std::vector<InstanceMasks> MasksOf(Renderer& renderer, const Camera& camera,
                                   std::span<const RenderInstance> instances,
                                   const Image<uint16_t>& ids, const Image<uint16_t>& depth);

}  // namespace pickbed::eval
