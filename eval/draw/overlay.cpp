#include "eval/draw/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "eval/draw/canvas.h"
#include "eval/draw/opencv_image.h"
#include "eval/draw/outline.h"
#include "eval/draw/silhouettes.h"

namespace pickbed::eval {
namespace {

constexpr Rgb8 kHandLine{240, 242, 245}, kHandFill{60, 66, 76};
constexpr double kHandOpacity = 0.55;

Image<Rgb8> FromBgr(const cv::Mat& bgr) {
  Image<Rgb8> image(bgr.cols, bgr.rows);
  cv::Mat out = MatrixOf(image);
  cv::cvtColor(bgr, out, cv::COLOR_BGR2RGB);
  return image;
}

Stroke StrokeOf(const OverlayPose& pose, const OverlayStyle& style) {
  return {ColorOf(pose.mark),
          pose.mark == PoseMark::kWrong ? LineStyle::kDashed : LineStyle::kSolid,
          pose.chosen ? 2 * style.line_px + 1 : style.line_px, std::max(1, style.line_px / 2)};
}

Stroke MissedStroke(const OverlayStyle& style) {
  return {kMissedColor, LineStyle::kDotted, style.line_px, 1};
}

Stroke TargetStroke(const OverlayStyle& style) {
  return {kTargetColor, LineStyle::kSolid, style.line_px + 1, 2};
}

Stroke RegionStroke(const OverlayStyle& style) {
  return {kTargetColor, LineStyle::kDashed, std::max(1, style.line_px / 2), 1};
}

// Darkens what is outside of the region of interest and draws the edges of its box.
void DrawRegion(const OverlayInput& input, const OverlayStyle& style, Canvas& canvas) {
  constexpr double kDarkness = 0.55;
  canvas.Blend({0, 0, 0}, [&](int x, int y) {
    return input.region->Contains(x, y) && (*input.region)(x, y) != 0 ? 0.0 : kDarkness;
  });
  std::vector<Polyline> lines;
  for (const auto& [a, b] : input.region_lines) lines.push_back({a, b});
  DrawCurves(canvas, lines, RegionStroke(style));
}

Stroke HandStroke(int line_px) { return {kHandLine, LineStyle::kSolid, line_px, 1}; }

// Rectangles of labels that are already placed.
class LabelPlaces {
 public:
  LabelPlaces(int width_px, int height_px) : page_(0, 0, width_px, height_px) {}

  // Returns a center near `wanted` at which a label of this size covers no other label; `wanted`
  // moved into the picture if there is none.
  Eigen::Vector2d Place(const Eigen::Vector2d& wanted, const Eigen::Vector2d& size_px) {
    for (const double ring : {0.0, 1.0, 2.0}) {
      for (const auto& [x, y] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}, {1, 1}, {-1, -1}}) {
        const Eigen::Vector2d step =
            1.06 * ring * Eigen::Vector2d(0.5 * x * size_px.x(), y * size_px.y());
        const cv::Rect2d there = Inside(wanted + step, size_px);
        if (std::ranges::any_of(taken_,
                                [&](const cv::Rect2d& t) { return (t & there).area() > 0; })) {
          continue;
        }
        return Take(there);
      }
    }
    return Take(Inside(wanted, size_px));
  }

 private:
  cv::Rect2d Inside(const Eigen::Vector2d& center, const Eigen::Vector2d& size_px) const {
    const auto clamped = [](double v, double size, double page) {
      return std::clamp(v - 0.5 * size, 0.0, std::max(0.0, page - size));
    };
    return {clamped(center.x(), size_px.x(), page_.width),
            clamped(center.y(), size_px.y(), page_.height), size_px.x(), size_px.y()};
  }
  Eigen::Vector2d Take(const cv::Rect2d& rect) {
    taken_.push_back(rect);
    return {rect.x + 0.5 * rect.width, rect.y + 0.5 * rect.height};
  }

  cv::Rect2d page_;
  std::vector<cv::Rect2d> taken_;
};

// A symbol and a score on each visible pose. Where the score does not fit, only the symbol is
// drawn.
void DrawLabels(const OverlayInput& input, const std::vector<Silhouette>& silhouettes,
                const OverlayStyle& style, Canvas& canvas) {
  LabelPlaces places(canvas.width(), canvas.height());
  const auto draw = [&](size_t i) {
    const OverlayPose& pose = input.poses[i];
    const Silhouette& region = silhouettes[i];
    if (region.curves.empty()) return;
    Plate plate{pose.mark, fmt::format("{:.2f}", pose.score), style.text_size};
    constexpr double kFits = 3.5;  // in radii of the largest disc in the region
    const bool fits =
        pose.chosen || PlateSize(plate).x() < kFits * region.inside_px || input.poses.size() <= 40;
    if (!fits) plate.text.clear();
    DrawPlate(canvas, plate, places.Place(region.inside, PlateSize(plate)));
  };
  for (const bool chosen : {true, false}) {
    if (!chosen && !style.all_labels) continue;
    for (size_t i = 0; i < input.poses.size(); ++i) {
      if (input.poses[i].chosen == chosen) draw(i);
    }
  }
}

}  // namespace

Rgb8 ScoreColor(double score) {
  const double s = std::clamp(score, 0.0, 1.0);
  constexpr Rgb8 kNeutral{236, 236, 232};
  return s < 0.5 ? Mixed(kWrongColor, kNeutral, 2 * s) : Mixed(kNeutral, kRightColor, 2 * s - 1);
}

Image<Rgb8> VisibleImage(const RgbdFrame& frame) {
  return frame.color.empty() ? ColorizeDepth(frame.depth_m) : frame.color;
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

void DrawHand(Canvas& canvas, const CameraIntrinsics& camera, const OverlayHand& hand,
              int line_px) {
  std::vector<AxisAlignedBox> boxes = hand.gripper.Boxes(hand.opening_m);
  // The palm hides everything below it, so only its outline is drawn.
  const AxisAlignedBox palm = boxes.back();
  boxes.pop_back();
  const std::vector<AxisAlignedBox> soft = hand.gripper.SoftBoxes();
  boxes.insert(boxes.end(), soft.begin(), soft.end());
  RegionMap fingers(camera), palm_only(camera);
  for (const AxisAlignedBox& box : boxes) fingers.Add(RasterMesh(BoxesMesh({box})), hand.X_CG);
  palm_only.Add(RasterMesh(BoxesMesh({palm})), hand.X_CG);
  const int fineness = fingers.fineness();
  canvas.Blend(kHandFill, [&](int x, int y) {
    int covered = 0;
    for (int j = 0; j < fineness; ++j) {
      for (int i = 0; i < fineness; ++i) {
        covered += fingers.ids()(x * fineness + i, y * fineness + j) > 0;
      }
    }
    return kHandOpacity * covered / (fineness * fineness);
  });
  DrawCurves(canvas, SilhouetteOf(palm_only.ids(), 1, fineness).curves, HandStroke(line_px));
  for (const Silhouette& finger :
       SilhouettesOf(fingers.ids(), static_cast<int>(boxes.size()), fineness)) {
    DrawCurves(canvas, finger.curves, HandStroke(2 * line_px));
  }
}

std::vector<KeyEntry> OverlayKey(const OverlayInput& input, const OverlayStyle& style) {
  std::map<PoseMark, int> counts;
  bool chosen = false;
  for (const OverlayPose& pose : input.poses) {
    ++counts[pose.mark];
    chosen |= pose.chosen;
  }
  std::vector<KeyEntry> key;
  const auto line = [&](const std::string& meaning, const Stroke& stroke) {
    key.push_back({meaning, KeyEntry::Sample::kLine, PoseMark::kUnknown, stroke});
  };
  const auto mark = [&](PoseMark of, const std::string& meaning) {
    OverlayPose pose;
    pose.mark = of;
    key.push_back({fmt::format("{}: {}", meaning, counts[of]), KeyEntry::Sample::kMark, of,
                   StrokeOf(pose, style)});
  };
  const bool judged = counts[PoseMark::kRight] + counts[PoseMark::kWrong] > 0;
  if (judged) {
    mark(PoseMark::kRight, "right");
    mark(PoseMark::kWrong, "wrong or duplicate");
  }
  if (counts[PoseMark::kUnknown] > 0) {
    line(fmt::format("estimated: {}", counts[PoseMark::kUnknown]), StrokeOf({}, style));
  }
  if (input.ids != nullptr && !input.missed.empty()) {
    line(fmt::format("not found: {}", input.missed.size()), MissedStroke(style));
  }
  if (input.ids != nullptr && input.target != kNoInstance)
    line("requested instance", TargetStroke(style));
  if (chosen) {
    line("pose of the grasp", {kUnjudgedColor, LineStyle::kSolid, 2 * style.line_px + 1, 1});
  }
  if (input.region != nullptr) line("region of interest: bright", RegionStroke(style));
  if (input.hand) line("hand", HandStroke(std::max(1, style.line_px / 2)));
  if (!input.poses.empty()) key.push_back({"number: score of the pose"});
  return key;
}

Image<Rgb8> DrawOverlay(const OverlayInput& input, const OverlayStyle& style) {
  Canvas canvas(input.picture);
  if (input.region != nullptr) DrawRegion(input, style, canvas);
  if (input.ids != nullptr) {
    for (const InstanceId instance : input.missed) {
      const Silhouette region =
          SilhouetteOf(*input.ids, static_cast<uint16_t>(instance + 1), 1, Holes::kWithout);
      DrawCurves(canvas, region.curves, MissedStroke(style));
    }
  }
  std::vector<PlacedObject> placed;
  for (const OverlayPose& pose : input.poses) placed.push_back({pose.object, pose.X_CO});
  const std::vector<Silhouette> silhouettes = SilhouettesOf(placed, input.objects, input.camera);
  // The chosen pose is drawn last, so that no other line covers it.
  for (const bool chosen : {false, true}) {
    for (size_t i = input.poses.size(); i-- > 0;) {
      if (input.poses[i].chosen != chosen) continue;
      DrawCurves(canvas, silhouettes[i].curves, StrokeOf(input.poses[i], style));
    }
  }
  if (input.ids != nullptr && input.target != kNoInstance) {
    const Silhouette region = SilhouetteOf(*input.ids, static_cast<uint16_t>(input.target + 1), 1);
    DrawCurves(canvas, region.curves, TargetStroke(style));
  }
  if (input.hand) DrawHand(canvas, input.camera, *input.hand, std::max(1, style.line_px / 2));
  DrawLabels(input, silhouettes, style, canvas);
  if (!style.legend) return canvas.Take();
  return WithKey(canvas.Take(), OverlayKey(input, style));
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
