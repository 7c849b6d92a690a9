#pragma once

// Pictures for people: what was seen, believed, chosen and left.

#include <filesystem>
#include <vector>

#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "perception/pose_hypothesis.h"
#include "scenes/camera.h"
#include "scenes/rgbd_frame.h"
#include "scenes/scene.h"

namespace pickbed {

struct OverlayInput {
  const RgbdFrame& frame;
  const Camera& camera;
  const ObjectSet& objects;
  const Scene& truth;
  const std::vector<PoseHypothesis>& hypotheses;
  const Grasp* grasp = nullptr;  // in W; may be null
  const GripperSpec* gripper = nullptr;
  const Image<uint16_t>* ids = nullptr;  // true instances, for their outlines
};

Rgb8 ScoreColor(double score);  // of a hypothesis: red for doubtful, yellow, green for sure
Image<Rgb8> ColorizeDepth(const Image<float>& depth_m);
Image<Rgb8> ColorizeIds(const Image<uint16_t>& ids);
// Colour image with truth outlines, hypotheses as wireframe edges coloured by score, chosen grasp.
Image<Rgb8> DrawOverlay(const OverlayInput& input);
// Tiles of equal size with captions, `columns` a row.
Image<Rgb8> ContactSheet(const std::vector<Image<Rgb8>>& tiles,
                         const std::vector<std::string>& captions, int columns);

}  // namespace pickbed
