#pragma once

// Draws the stages of an estimate over its input image.

#include <string>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/draw/marks.h"
#include "eval/draw/outline.h"
#include "perception/candidates/estimate_trace.h"
#include "scenes/base/ids.h"
#include "scenes/camera/rgbd_frame.h"

namespace pickbed::eval {

// For all kinds of color vision: blue, yellow and orange also differ in brightness.
inline constexpr Rgb8 kNearColor{255, 236, 120};
inline constexpr Rgb8 kUnknownColor{225, 130, 190}, kPaleColor{165, 170, 180};

// Enlarged part of an image to draw on, and the camera that matches it.
struct Board {
  Board(const RgbdFrame& frame, const ImageBox& shown);
  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const;  // frame pixel -> board pixel

  ImageBox region;  // of the frame
  int zoom = 1;
  CameraIntrinsics camera;  // intrinsics of the enlarged image
  Image<Rgb8> color;
  Image<Rgb8> faded;
};

// Foreground in its colors, the rest dimmed, pixels without a reading violet.
Image<Rgb8> DrawForeground(const RgbdFrame& frame, const OrganizedCloud& cloud);

struct ColoredDot {
  Eigen::Vector2d pixel;  // in the frame
  Rgb8 color;
};
// Draws dots of `radius_px` on the faded image of the board, with a legend.
Image<Rgb8> DrawDots(const Board& board, const std::vector<ColoredDot>& dots, double radius_px,
                     const std::vector<LegendEntry>& legend);

// Heat map of the object centers for which the patches vote. `centers` are in frame pixels and are
// smoothed with `sigma_px` (frame pixels). `rings` are drawn on top.
Image<Rgb8> DrawVoteMap(const Board& board, const std::vector<Eigen::Vector2d>& centers,
                        double sigma_px, const std::vector<ColoredDot>& rings,
                        const std::vector<LegendEntry>& legend);

struct DrawnPose {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
  Rgb8 color;
  std::string label = {};               // drawn in its visible region
  PoseMark mark = PoseMark::kUnknown;   // symbol before the label
  LineStyle style = LineStyle::kSolid;  // of the silhouette
};
// Draws the silhouettes of the poses. Nearer poses hide those behind them.
Image<Rgb8> DrawPoses(const Board& board, const ObjectSet& objects,
                      const std::vector<DrawnPose>& poses, const std::vector<KeyEntry>& key);
// Returns the legend as colored lines. The line of wrong poses is dashed.
std::vector<KeyEntry> LineKey(const std::vector<LegendEntry>& legend);

// Returns the part of an image in which the cloud has foreground, with a margin; the whole image if
// there is none.
ImageBox ForegroundRegion(const OrganizedCloud& cloud);

}  // namespace pickbed::eval
