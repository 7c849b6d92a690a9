#pragma once

// Overlay pictures of an attempt: silhouettes of the estimated poses, their symbols and scores, the
// hand at the chosen grasp, and a legend.

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "eval/draw/marks.h"
#include "eval/layer.h"
#include "grasp/gripper.h"
#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/rgbd_frame.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// An estimated pose in an overlay.
struct OverlayPose {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  double score = 0;
  PoseMark mark = PoseMark::kUnknown;
  bool chosen = false;  // the pose of the chosen grasp
};

// The hand at a grasp.
struct OverlayHand {
  const Gripper& gripper;
  Pose X_CG = Pose::Identity();
  double opening_m = 0;
};

// Data of an overlay picture. References must outlive the call.
struct OverlayInput {
  const Image<Rgb8>& picture;
  CameraIntrinsics camera;  // of the picture
  const ObjectSet& objects;
  std::vector<OverlayPose> poses;  // of two equal poses the first is visible
  std::optional<OverlayHand> hand = {};
  // Instance + 1 at each pixel of the picture, 0 = background. Null: `missed` and `target` are not
  // drawn.
  const Image<uint16_t>* ids = nullptr;
  std::vector<InstanceId> missed = {};  // instances without a right pose
  InstanceId target = kNoInstance;      // the instance that was requested
  // Region of interest of the picture; what is outside is darkened. Null: none.
  const Image<uint8_t>* region = nullptr;
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> region_lines = {};  // of its box, px
};

// Effort and size of an overlay.
struct OverlayStyle {
  bool legend = true;
  bool all_labels = true;  // false: only the chosen pose has a symbol and a score
  int line_px = 2;
  double text_size = 0.42;  // as in Canvas::Text
};

// Returns the picture with the overlay and, below it, the legend.
Image<Rgb8> DrawOverlay(const OverlayInput& input, const OverlayStyle& style = {});
// Returns the legend of an overlay: the symbols and lines in it with their numbers.
std::vector<KeyEntry> OverlayKey(const OverlayInput& input, const OverlayStyle& style = {});
// Draws the hand of a gripper: its fingers or its stem and cup, transparent, and the outline of its
// palm.
void DrawHand(Canvas& canvas, const CameraIntrinsics& camera, const OverlayHand& hand,
              int line_px = 1);

Rgb8 ScoreColor(double score);  // of a hypothesis: orange for 0, light grey, blue for 1
// Depth as colors (Turbo), near is red; pixels without a reading are black.
Image<Rgb8> ColorizeDepth(const Image<float>& depth_m);
// The color image of a frame; its colorized depth if it has none.
Image<Rgb8> VisibleImage(const RgbdFrame& frame);
// One color per instance id; id 0 (background) is black.
Image<Rgb8> ColorizeIds(const Image<uint16_t>& ids);
// Tiles of equal size with captions, `columns` per row.
Image<Rgb8> ContactSheet(const std::vector<Image<Rgb8>>& tiles,
                         const std::vector<std::string>& captions, int columns);

// Size and JPEG quality of small pictures in a report.
struct PictureSize {
  int width_px = 520;  // 64..4096
  int quality = 78;    // 1..100
};

}  // namespace pickbed::eval
