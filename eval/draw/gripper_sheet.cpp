#include "eval/draw/gripper_sheet.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "eval/draw/canvas.h"
#include "grasp/grippers/table.h"

namespace pickbed::eval {
namespace {

using Eigen::Vector2d;

constexpr int kWidth = 1280, kMaxHeight = 760;
constexpr int kPanel = kWidth / 2;
constexpr double kAxes_px = 60;                        // length of the axes of G
constexpr int kTop = 110, kBottom = 110, kSide = 150;  // margins for captions and dimensions
constexpr Rgb8 kSheetPaper{255, 255, 255}, kSheetInk{40, 40, 40}, kSheetGrid{225, 228, 232};
constexpr Rgb8 kBody{150, 170, 200}, kOpen{205, 215, 230}, kSize{120, 120, 120};
constexpr Rgb8 kAxisX{200, 40, 40}, kAxisY{40, 140, 60}, kAxisZ{30, 90, 180};

// View along y (`across` = 0: x to the right) or along x (1: y to the right).
struct FlatView {
  int across;
  Vector2d origin_px;  // of G
  double scale;        // px/m
  Vector2d Place(double u_m, double z_m) const { return origin_px + scale * Vector2d(u_m, z_m); }
};

void DrawBox(Canvas& canvas, const FlatView& view, const AxisAlignedBox& box, Rgb8 fill) {
  const double u = box.center[view.across], du = box.half_size[view.across];
  const double z = box.center.z(), dz = box.half_size.z();
  const Vector2d low = view.Place(u - du, z - dz), high = view.Place(u + du, z + dz);
  const int x = static_cast<int>(std::lround(low.x())), y = static_cast<int>(std::lround(low.y()));
  const int width = std::max(2, static_cast<int>(std::lround(high.x())) - x + 1);
  const int height = std::max(2, static_cast<int>(std::lround(high.y())) - y + 1);
  canvas.Fill(x, y, width, height, fill);
  canvas.Frame(x, y, width, height, kSheetInk, 1);
}

// Dimension line with end marks and its length, near the measured extent.
void DrawWidth(Canvas& canvas, const FlatView& view, double from_m, double to_m, double y_px,
               const std::string& what) {
  const Vector2d a(view.Place(from_m, 0).x(), y_px), b(view.Place(to_m, 0).x(), y_px);
  canvas.Line(a, b, kSize);
  for (const Vector2d& end : {a, b}) canvas.Line(end - Vector2d(0, 5), end + Vector2d(0, 5), kSize);
  const std::string text = fmt::format("{}{:.0f} mm", what, 1e3 * (to_m - from_m));
  canvas.Text(text, static_cast<int>(0.5 * (a.x() + b.x()) - 0.5 * TextWidth(text)),
              static_cast<int>(y_px) - 8, kSheetInk);
}

void DrawHeight(Canvas& canvas, const FlatView& view, double from_m, double to_m, double x_px,
                const char* what = "") {
  const Vector2d a(x_px, view.Place(0, from_m).y()), b(x_px, view.Place(0, to_m).y());
  canvas.Line(a, b, kSize);
  for (const Vector2d& end : {a, b}) canvas.Line(end - Vector2d(5, 0), end + Vector2d(5, 0), kSize);
  canvas.Text(fmt::format("{:.0f} mm{}", 1e3 * (to_m - from_m), what), static_cast<int>(x_px) + 10,
              static_cast<int>(0.5 * (a.y() + b.y())) + 5, kSheetInk);
}

void DrawFrame(Canvas& canvas, const FlatView& view) {
  const Vector2d o = view.origin_px;
  const bool is_front = view.across == 0;
  canvas.Line(o, o + Vector2d(kAxes_px, 0), is_front ? kAxisX : kAxisY, 3);
  canvas.Line(o, o + Vector2d(0, kAxes_px), kAxisZ, 3);
  canvas.Dot(o, 5, kSheetInk);
  canvas.Text(is_front ? "x" : "y", static_cast<int>(o.x() + kAxes_px) + 8,
              static_cast<int>(o.y()) + 5, is_front ? kAxisX : kAxisY, 0.6);
  canvas.Text("z, approach", static_cast<int>(o.x()) + 10, static_cast<int>(o.y() + kAxes_px) + 8,
              kAxisZ, 0.6);
  canvas.Text("G", static_cast<int>(o.x()) - 22, static_cast<int>(o.y()) + 20, kSheetInk, 0.6);
}

Eigen::AlignedBox3d BoundsOf(const std::vector<AxisAlignedBox>& boxes) {
  Eigen::AlignedBox3d bounds(Eigen::Vector3d::Zero().eval());
  for (const AxisAlignedBox& box : boxes) {
    bounds.extend(Eigen::Vector3d(box.center - box.half_size));
    bounds.extend(Eigen::Vector3d(box.center + box.half_size));
  }
  return bounds;
}

}  // namespace

Image<Rgb8> GripperSheet(const Gripper& gripper) {
  const std::vector<AxisAlignedBox> open = gripper.Boxes(gripper.MaxOpening_m());
  const Eigen::AlignedBox3d bounds = BoundsOf(open);
  const double scale = std::min((kPanel - 2.0 * kSide) / bounds.sizes().head<2>().maxCoeff(),
                                (kMaxHeight - kTop - kBottom - 70.0) / bounds.sizes().z());
  const int height = kTop + static_cast<int>(scale * bounds.sizes().z()) + kBottom + 40;
  Canvas canvas(kWidth, height, kSheetPaper);
  canvas.Text(fmt::format("{}: {}, {}", gripper.name, gripper.mechanism(), gripper.Summary()), 24,
              36, kSheetInk, 0.7);
  for (const int across : {0, 1}) {
    const FlatView view{across, {kPanel * (across + 0.5), kTop - scale * bounds.min().z()}, scale};
    canvas.Text(across == 0 ? "from the front" : "from the side", kPanel * across + 24, 66,
                kSheetInk, 0.55);
    for (const AxisAlignedBox& box : open) DrawBox(canvas, view, box, kBody);
    for (const AxisAlignedBox& box : gripper.SoftBoxes()) DrawBox(canvas, view, box, kOpen);
    DrawWidth(canvas, view, bounds.min()[across], bounds.max()[across], kTop - 14, "");
    const double right_px =
        std::max(view.Place(bounds.max()[across], 0).x(), view.origin_px.x() + kAxes_px + 20);
    // Height of each box once, from the palm to the tip.
    double last_low = 1, last_high = 1;
    for (const AxisAlignedBox& box : open) {
      const double low = box.center.z() - box.half_size.z();
      const double high = box.center.z() + box.half_size.z();
      if (low == last_low && high == last_high) continue;
      DrawHeight(canvas, view, low, high, right_px + 24);
      last_low = low;
      last_high = high;
    }
    for (const AxisAlignedBox& box : gripper.SoftBoxes()) {
      DrawHeight(canvas, view, box.center.z() - box.half_size.z(),
                 box.center.z() + box.half_size.z(), right_px + 24, ", compliant");
    }
    const double opening_m = gripper.MaxOpening_m();
    if (across == 0 && opening_m > 0) {
      DrawWidth(canvas, view, -0.5 * opening_m, 0.5 * opening_m, view.origin_px.y() - 30, "opens ");
    }
    const AxisAlignedBox& first = open.front();
    DrawWidth(canvas, view, first.center[across] - first.half_size[across],
              first.center[across] + first.half_size[across], view.origin_px.y() + 110, "");
    DrawFrame(canvas, view);
  }
  canvas.Line({kPanel, 50}, {kPanel, height - 20.0}, kSheetGrid);
  return canvas.Take();
}

std::string GripperText(const Gripper& gripper) { return gripper.SettingsHelp(MechanismNames()); }

}  // namespace pickbed::eval
