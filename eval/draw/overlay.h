#pragma once

// Overlay pictures of an attempt: observed image, true outlines, estimated poses, chosen grasp.

#include <filesystem>
#include <vector>

#include "eval/layer.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "perception/pose_hypothesis.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Data of an overlay picture. References must outlive the call.
struct OverlayInput {
  const RgbdFrame& frame;
  const Camera& camera;
  const ObjectSet& objects;
  std::vector<PoseHypothesis> hypotheses;
  const Grasp* grasp = nullptr;  // in W; may be null
  const Gripper* gripper = nullptr;
  const Image<uint16_t>* ids = nullptr;  // true instance ids, for their outlines
};

Rgb8 ScoreColor(double score);  // of a hypothesis: red for 0, yellow, green for 1
// Depth as colors (Turbo), near is red; pixels without a reading are black.
Image<Rgb8> ColorizeDepth(const Image<float>& depth_m);
// One color per instance id; id 0 (background) is black.
Image<Rgb8> ColorizeIds(const Image<uint16_t>& ids);
// Color image with true outlines, hypotheses as wireframes colored by score, and the chosen grasp.
Image<Rgb8> DrawOverlay(const OverlayInput& input);
// Tiles of equal size with captions, `columns` per row.
Image<Rgb8> ContactSheet(const std::vector<Image<Rgb8>>& tiles,
                         const std::vector<std::string>& captions, int columns);

// Size and JPEG quality of small pictures in a report.
struct PictureSize {
  int width_px = 520;  // 64..4096
  int quality = 72;    // 1..100
};

}  // namespace pickbed::eval
