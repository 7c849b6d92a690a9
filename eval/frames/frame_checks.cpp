#include "eval/frames/frame_checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "eval/frames/edge_alignment.h"

namespace pickbed::eval {
namespace {

// Readings of a depth image, sorted by quantiles on demand.
class Readings {
 public:
  explicit Readings(const Image<float>& depth_m) {
    for (const float z : depth_m.pixels()) {
      if (z > 0) values_.push_back(z);
    }
  }
  bool empty() const { return values_.empty(); }
  size_t size() const { return values_.size(); }
  double Quantile(double share) {
    const auto nth = values_.begin() + static_cast<long>(share * (values_.size() - 1));
    std::nth_element(values_.begin(), nth, values_.end());
    return *nth;
  }

 private:
  std::vector<float> values_;
};

// Returns the usual scales (mm per unit) with which the median depth is the depth of a camera that
// looks at objects.
std::vector<double> LikelyScales_mm(double median_m, double depth_scale_mm) {
  constexpr double kNear_m = 0.2, kFar_m = 4;
  std::vector<double> likely;
  for (const double scale : {0.01, 0.1, 0.125, 0.25, 1.0, 10.0, 1000.0}) {
    const double would_be_m = median_m * scale / depth_scale_mm;
    if (would_be_m >= kNear_m && would_be_m <= kFar_m) likely.push_back(scale);
  }
  return likely;
}

std::string ScaleRemedy(double median_m, double depth_scale_mm) {
  const std::vector<double> likely = LikelyScales_mm(median_m, depth_scale_mm);
  if (likely.empty()) return "check the unit of the depth image";
  return fmt::format("give the depth scale, for example {} mm per unit instead of {}",
                     fmt::join(likely, " or "), depth_scale_mm);
}

void CheckRange(const RgbdFrame& frame, double depth_scale_mm, Readings& readings,
                std::vector<FrameFinding>& findings) {
  constexpr double kNearest_m = 0.03, kFarthest_m = 15;
  constexpr double kUsualNear_m = 0.1, kUsualFar_m = 5;
  constexpr double kFewReadings = 0.02;
  const double median_m = readings.Quantile(0.5);
  if (median_m < kUsualNear_m || median_m > kUsualFar_m) {
    findings.push_back({FrameFault::kRange, median_m < kNearest_m || median_m > kFarthest_m,
                        fmt::format("the median depth would be {:.4g} m, which is unusual for a "
                                    "camera over parts; {}",
                                    median_m, ScaleRemedy(median_m, depth_scale_mm))});
  }
  const double share = static_cast<double>(readings.size()) / frame.depth_m.size();
  if (share < kFewReadings) {
    findings.push_back(
        {FrameFault::kFewReadings, false,
         fmt::format("only {:.1f} % of the depth pixels have a reading; check the range and "
                     "the exposure of the camera",
                     100 * share)});
  }
}

// The nearest and farthest readings decide, because the objects may be anywhere in the image.
void CheckSizes(const RgbdFrame& frame, const ObjectSet& objects, double depth_scale_mm,
                Readings& readings, std::vector<FrameFinding>& findings) {
  constexpr double kNearShare = 0.05, kFarShare = 0.95;
  const double near_m = readings.Quantile(kNearShare), far_m = readings.Quantile(kFarShare);
  const double focal_px = std::sqrt(frame.intrinsics.fx() * frame.intrinsics.fy());
  const double side_px = std::max(frame.depth_m.width(), frame.depth_m.height());
  for (const auto& object : objects) {
    const double largest_px = focal_px * object->diameter_m / near_m;
    const double smallest_px = focal_px * object->diameter_m / far_m;
    const bool is_small = largest_px<kGoodDiameter_px, is_large = smallest_px> side_px;
    if (!is_small && !is_large) continue;
    const bool is_error = largest_px < kMinimumDiameter_px || smallest_px > 2 * side_px;
    findings.push_back(
        {FrameFault::kSize, is_error,
         fmt::format("object '{}' would be {:.3g} px wide at {:.3g} m (its diameter is {:.3g} m, "
                     "the image {} px wide); check the unit of its mesh and the depth scale of {} "
                     "mm per unit",
                     object->name, is_small ? largest_px : smallest_px, is_small ? near_m : far_m,
                     object->diameter_m, frame.depth_m.width(), depth_scale_mm)});
  }
}

void CheckPrincipalPoint(const CameraIntrinsics& k, std::vector<FrameFinding>& findings) {
  constexpr double kFarShare = 0.3;
  const double du = std::abs(k.cx() - 0.5 * (k.width() - 1)) / k.width();
  const double dv = std::abs(k.cy() - 0.5 * (k.height() - 1)) / k.height();
  if (du < kFarShare && dv < kFarShare) return;
  findings.push_back(
      {FrameFault::kPrincipalPoint, false,
       fmt::format("the principal point ({:.0f}, {:.0f}) is far from the center of the image "
                   "of {}x{} px; check that the intrinsics are of this image",
                   k.cx(), k.cy(), k.width(), k.height())});
}

void CheckEdges(const RgbdFrame& frame, std::vector<FrameFinding>& findings) {
  // Color that is moved by 8 px has a smaller fit in three real frames.
  constexpr double kMinFit = 0.9;
  // The usual error of a registration grows with the size of the image.
  const double min_corner_shift_px = 6 * std::max(1.0, frame.intrinsics.width() / 640.0);
  const std::optional<EdgeAlignment> found = AlignEdges(frame);
  if (!found || found->fit_here >= kMinFit) return;
  constexpr const char* kCheck =
      "check that depth is registered to this color image with its intrinsics";
  if (found->flip != DepthFlip::kNone) {
    const char* how = found->flip == DepthFlip::kColumns ? "mirrored left to right"
                      : found->flip == DepthFlip::kRows  ? "mirrored top to bottom"
                                                         : "turned by 180 degrees";
    findings.push_back({FrameFault::kEdges, false,
                        fmt::format("the depth edges contradict the color edges: they fit when "
                                    "the depth image is {}; give both images in one orientation",
                                    how)});
    return;
  }
  if (found->CornerShift_px(frame.intrinsics) < min_corner_shift_px) return;
  const bool is_shift = found->scale == 1;
  const std::string remedy = is_shift ? "; the color image is moved accordingly"
                                      : fmt::format(" and scaled by {:.2f}", found->scale);
  FrameFinding finding{
      FrameFault::kEdges, false,
      fmt::format("the depth edges contradict the color edges: they fit when moved by ({:.0f}, "
                  "{:.0f}) px{}; {}",
                  found->shift_px.x(), found->shift_px.y(), remedy, kCheck)};
  if (is_shift) finding.color_move_px = (-found->shift_px).array().round().matrix().cast<int>();
  findings.push_back(std::move(finding));
}

}  // namespace

std::vector<FrameFinding> CheckFrame(const RgbdFrame& frame, const ObjectSet& objects,
                                     double depth_scale_mm) {
  Readings readings(frame.depth_m);
  if (readings.empty()) {
    return {{FrameFault::kNoReadings, true,
             "no pixel of the depth image has a reading; check the file and the range of the "
             "camera"}};
  }
  std::vector<FrameFinding> findings;
  CheckRange(frame, depth_scale_mm, readings, findings);
  CheckSizes(frame, objects, depth_scale_mm, readings, findings);
  CheckPrincipalPoint(frame.intrinsics, findings);
  CheckEdges(frame, findings);
  std::ranges::stable_partition(findings, [](const FrameFinding& f) { return f.is_error; });
  return findings;
}

void RegisterColor(const std::vector<FrameFinding>& findings, RgbdFrame& frame) {
  for (const FrameFinding& finding : findings) {
    const Eigen::Vector2i& move = finding.color_move_px;
    if (move.isZero()) continue;
    const Image<Rgb8> color = frame.color;
    for (int y = 0; y < color.height(); ++y) {
      const int v = std::clamp(y - move.y(), 0, color.height() - 1);
      for (int x = 0; x < color.width(); ++x) {
        frame.color(x, y) = color(std::clamp(x - move.x(), 0, color.width() - 1), v);
      }
    }
  }
}

}  // namespace pickbed::eval
