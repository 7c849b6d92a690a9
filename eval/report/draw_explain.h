#pragma once

// Pictures of the stages of an estimate, drawn over the image that it looked at.

#include <string>
#include <vector>

#include "eval/report/draw_canvas.h"
#include "eval/report/outline.h"
#include "perception/estimate_trace.h"
#include "scenes/rgbd_frame.h"

namespace pickbed::explain {

inline constexpr Rgb8 kRight{70, 205, 95}, kNear{245, 185, 45}, kWrong{235, 62, 52};
inline constexpr Rgb8 kUnknown{85, 165, 255}, kPale{165, 170, 180};

// The image, faded and enlarged to be drawn on, and the camera that sees it so.
struct Board {
  explicit Board(const RgbdFrame& frame);
  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const;  // of the frame

  int zoom = 1;
  CameraIntrinsics camera;
  Image<Rgb8> color;  // not faded
  Image<Rgb8> faded;
};

// What is foreground in its colours; the rest dimmed, no reading violet.
Image<Rgb8> DrawForeground(const RgbdFrame& frame, const OrganizedCloud& cloud);

struct ColoredDot {
  Eigen::Vector2d pixel;  // of the frame
  Rgb8 color;
};
Image<Rgb8> DrawDots(const Board& board, const std::vector<ColoredDot>& dots, double radius_px,
                     const std::vector<LegendEntry>& legend);

// Where the votes put the middle of a part, as a heat map; `rings` are drawn about pixels.
Image<Rgb8> DrawVoteMap(const Board& board, const std::vector<Eigen::Vector2d>& centers,
                        double sigma_px, const std::vector<ColoredDot>& rings,
                        const std::vector<LegendEntry>& legend);

struct DrawnPose {
  int object = 0;
  Pose X_CO = Pose::Identity();
  Rgb8 color;
  std::string label = {};  // at its middle
  bool crossed = false;    // marked as wrong
};
// The first on top.
Image<Rgb8> DrawPoses(const Board& board, PartOutlines& outlines, const ObjectSet& objects,
                      const std::vector<DrawnPose>& poses, const std::vector<LegendEntry>& legend);

// Red for doubtful, yellow, green for sure; 0..1.
Rgb8 ScoreColor(double score);

}  // namespace pickbed::explain
