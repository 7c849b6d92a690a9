#include "eval/draw/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "eval/draw/canvas.h"
#include "eval/draw/opencv_image.h"
#include "eval/draw/outline.h"
#include "sim/hands/jaw_hand.h"

namespace pickbed::eval {
namespace {

constexpr double kGraspNear_m = 0.02;
constexpr int kSubPixelBits = 4;  // sub-pixel bits of cv::line

Image<Rgb8> FromBgr(const cv::Mat& bgr) {
  Image<Rgb8> image(bgr.cols, bgr.rows);
  cv::Mat out = MatrixOf(image);
  cv::cvtColor(bgr, out, cv::COLOR_BGR2RGB);
  return image;
}

void DrawLine(cv::Mat& canvas, const PixelLine& line, const cv::Scalar& color, int width_px) {
  const Eigen::Vector2d a = line.a * (1 << kSubPixelBits), b = line.b * (1 << kSubPixelBits);
  cv::line(canvas, cv::Point(std::lround(a.x()), std::lround(a.y())),
           cv::Point(std::lround(b.x()), std::lround(b.y())), color, width_px, cv::LINE_AA,
           kSubPixelBits);
}

void DrawSegment(cv::Mat& canvas, const CameraIntrinsics& k, const Eigen::Vector3d& a_C,
                 const Eigen::Vector3d& b_C, const cv::Scalar& color, int width_px) {
  if (a_C.z() < kGraspNear_m || b_C.z() < kGraspNear_m) return;
  DrawLine(canvas, {Project(k, a_C), Project(k, b_C)}, color, width_px);
}

void DrawInstanceOutlines(cv::Mat& canvas, const Image<uint16_t>& ids) {
  for (int y = 0; y + 1 < ids.height(); ++y) {
    for (int x = 0; x + 1 < ids.width(); ++x) {
      const uint16_t id = ids(x, y);
      if (id != ids(x + 1, y) || id != ids(x, y + 1)) {
        canvas.at<cv::Vec3b>(y, x) = {255, 255, 255};
      }
    }
  }
}

void DrawGrasp(cv::Mat& canvas, const CameraIntrinsics& k, const Pose& X_CG, const Gripper& gripper,
               double width_m) {
  const cv::Scalar color(70, 160, 255);
  for (const AxisAlignedBox& box : gripper.Boxes(width_m)) {
    const auto corner = [&](int i) {
      const Eigen::Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      return X_CG * Eigen::Vector3d(box.center + sign.cwiseProduct(box.half_size));
    };
    for (int i = 0; i < 8; ++i) {
      for (const int bit : {1, 2, 4}) {
        if (!(i & bit)) DrawSegment(canvas, k, corner(i), corner(i | bit), color, 2);
      }
    }
  }
}

}  // namespace

Rgb8 ScoreColor(double score) {
  const double s = std::clamp(score, 0.0, 1.0);
  return {static_cast<uint8_t>(255 * std::min(1.0, 2 - 2 * s)),
          static_cast<uint8_t>(255 * std::min(1.0, 2 * s)), 40};
}

Image<Rgb8> ColorizeDepth(const Image<float>& depth_m) {
  std::vector<float> known;
  for (const float z : depth_m.pixels()) {
    if (z > 0) known.push_back(z);
  }
  cv::Mat grey(depth_m.height(), depth_m.width(), CV_8UC1, cv::Scalar(0));
  float near = 0, far = 1;
  if (!known.empty()) {
    // The colors cover the central 98 %, so that a few far pixels do not reduce the contrast.
    const auto at = [&known](double share) {
      const auto nth = known.begin() + static_cast<long>(share * (known.size() - 1));
      std::nth_element(known.begin(), nth, known.end());
      return *nth;
    };
    near = at(0.01);
    far = std::max(at(0.99), near + 1e-4f);
  }
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      const float t = (depth_m(x, y) - near) / (far - near);
      grey.at<uint8_t>(y, x) = static_cast<uint8_t>(255 * (1 - std::clamp(t, 0.f, 1.f)));
    }
  }
  cv::Mat bgr;
  cv::applyColorMap(grey, bgr, cv::COLORMAP_TURBO);
  for (int y = 0; y < depth_m.height(); ++y) {
    for (int x = 0; x < depth_m.width(); ++x) {
      if (depth_m(x, y) <= 0) bgr.at<cv::Vec3b>(y, x) = {0, 0, 0};
    }
  }
  return FromBgr(bgr);
}

Image<Rgb8> ColorizeIds(const Image<uint16_t>& ids) {
  Image<Rgb8> image(ids.width(), ids.height());
  for (size_t i = 0; i < ids.size(); ++i) {
    const uint32_t id = ids.data()[i];
    if (id == 0) continue;
    // Multiplication by odd constants spreads neighboring ids over the color cube.
    image.data()[i] = {static_cast<uint8_t>(64 + id * 97 % 192),
                       static_cast<uint8_t>(64 + id * 57 % 192),
                       static_cast<uint8_t>(64 + id * 151 % 192)};
  }
  return image;
}

Image<Rgb8> DrawOverlay(const OverlayInput& input) {
  Image<Rgb8> image =
      input.frame.color.empty() ? ColorizeDepth(input.frame.depth_m) : input.frame.color;
  cv::Mat canvas = MatrixOf(image);
  const CameraIntrinsics& k = input.camera.intrinsics;
  if (input.ids) DrawInstanceOutlines(canvas, *input.ids);
  ObjectOutlines outlines(input.objects);
  for (auto h = input.hypotheses.rbegin(); h != input.hypotheses.rend(); ++h) {
    for (const PixelLine& line : outlines.At(h->object, h->X_CO, k)) {
      DrawLine(canvas, line, ToScalar(ScoreColor(h->score)), 1);
    }
  }
  if (input.grasp && input.gripper) {
    const Pose X_CG = input.camera.X_CW() * input.grasp->X_WG;
    DrawGrasp(canvas, k, X_CG, *input.gripper, input.grasp->width_m);
  }
  return image;
}

Image<Rgb8> ContactSheet(const std::vector<Image<Rgb8>>& tiles,
                         const std::vector<std::string>& captions, int columns) {
  if (tiles.empty() || columns < 1) return {};
  constexpr int kCaption_px = 22, kGap_px = 6;
  const int width = tiles.front().width(), height = tiles.front().height();
  const int rows = (static_cast<int>(tiles.size()) + columns - 1) / columns;
  Canvas sheet(columns * (width + kGap_px) + kGap_px,
               rows * (height + kCaption_px + kGap_px) + kGap_px, {250, 250, 250});
  for (size_t i = 0; i < tiles.size(); ++i) {
    const int x = kGap_px + static_cast<int>(i) % columns * (width + kGap_px);
    const int y = kGap_px + static_cast<int>(i) / columns * (height + kCaption_px + kGap_px);
    sheet.Paste(tiles[i], x, y + kCaption_px);
    if (i < captions.size()) {
      sheet.TextWithin(width - 2, captions[i], x + 2, y + 16, {20, 20, 20}, 0.48);
    }
  }
  return sheet.Take();
}

}  // namespace pickbed::eval
