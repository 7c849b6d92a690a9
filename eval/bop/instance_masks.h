#pragma once

// The truth of a rendered image, instance by instance: masks, pixel counts and boxes, by the
// definitions of BOP's scene_gt_info.json and mask folders. Choices where these leave one:
// - Visible is what the id image shows. (The BOP toolkit, which has only depth to go by, takes a
//   pixel as visible up to 15 mm behind the measured surface, and so counts parts that lie close
//   beneath another as seen.)
// - px_count_all and bbox_obj are of the whole silhouette, also where it leaves the image; an
//   instance that reaches behind the camera is cut at 4096 px around the image's middle.
// - mask is the silhouette inside the image whatever stands before it, so a hidden instance has a
//   mask, and a mask_visib without a pixel.
// - Boxes are x, y, and last minus first column and row, as the toolkit computes them: a single
//   pixel has width 0. Both are -1 -1 -1 -1 for an instance without a visible pixel.

#include <span>
#include <vector>

#include "eval/bop/dataset.h"
#include "sim/renderer.h"

namespace pickbed::bop {

struct InstanceMasks {
  InstanceInfo info;
  Image<uint8_t> mask, mask_visib;  // 0 or 255
};

// `ids` is what `camera` saw of all instances, whose ids must be non-zero and differ; `depth` is
// any image of its size that has 0 where the sensor read nothing.
std::vector<InstanceMasks> MasksOf(Renderer& renderer, const Camera& camera,
                                   std::span<const RenderInstance> instances,
                                   const Image<uint16_t>& ids, const Image<uint16_t>& depth);

}  // namespace pickbed::bop
