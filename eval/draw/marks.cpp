#include "eval/draw/marks.h"

#include <algorithm>
#include <cmath>

namespace pickbed::eval {
namespace {

using Eigen::Vector2d;

constexpr Rgb8 kHalo{12, 14, 18}, kMarkInk{255, 255, 255};
constexpr Rgb8 kPlate{20, 23, 29};
constexpr double kPlateOpacity = 0.72;
constexpr Rgb8 kKeyPaper{250, 250, 250}, kKeyInk{30, 34, 40};
constexpr double kKeyText = 0.5;

double LengthOf(const Polyline& curve) {
  double length_px = 0;
  for (size_t i = 0; i < curve.size(); ++i) {
    length_px += (curve[(i + 1) % curve.size()] - curve[i]).norm();
  }
  return length_px;
}

// The drawn pieces of a closed curve with a pattern of `on_px` drawn and `off_px` omitted. The
// pattern is stretched to a whole number of periods.
std::vector<Polyline> PiecesOf(const Polyline& curve, double on_px, double off_px) {
  constexpr double kStep_px = 0.5;
  const double length_px = LengthOf(curve);
  const double periods = std::max(1.0, std::round(length_px / (on_px + off_px)));
  const double period_px = length_px / periods, on = period_px * on_px / (on_px + off_px);
  std::vector<Polyline> pieces;
  double at_px = 0;
  bool drawing = false;
  for (size_t i = 0; i < curve.size(); ++i) {
    const Vector2d a = curve[i], b = curve[(i + 1) % curve.size()];
    const double edge_px = (b - a).norm();
    const int steps = std::max(1, static_cast<int>(std::ceil(edge_px / kStep_px)));
    for (int k = 0; k < steps; ++k) {
      const bool on_here = std::fmod(at_px + (k + 0.5) / steps * edge_px, period_px) < on;
      if (on_here && !drawing) pieces.push_back({a + (b - a) * (double(k) / steps)});
      if (on_here) pieces.back().push_back(a + (b - a) * ((k + 1.0) / steps));
      drawing = on_here;
    }
    at_px += edge_px;
  }
  return pieces;
}

double IconRadius(const Plate& plate) { return std::max(4.0, 15 * plate.text_size); }

}  // namespace

Rgb8 ColorOf(PoseMark mark) {
  switch (mark) {
    case PoseMark::kRight:
      return kRightColor;
    case PoseMark::kWrong:
      return kWrongColor;
    case PoseMark::kUnknown:
      break;
  }
  return kUnjudgedColor;
}

void DrawCurves(Canvas& canvas, const std::vector<Polyline>& curves, const Stroke& stroke) {
  const int halo_px = stroke.width_px + 2 * stroke.halo_px;
  const double dot_px = std::max(1.0, 0.9 * stroke.width_px);
  for (const bool halo : {true, false}) {
    const Rgb8 color = halo ? kHalo : stroke.color;
    const int width_px = halo ? halo_px : stroke.width_px;
    for (const Polyline& curve : curves) {
      if (stroke.style == LineStyle::kSolid) {
        canvas.Curve(curve, true, color, width_px);
        continue;
      }
      const bool dashed = stroke.style == LineStyle::kDashed;
      const double on_px = dashed ? 5.0 * stroke.width_px : dot_px;
      const double off_px = dashed ? 3.5 * stroke.width_px : 4.5 * stroke.width_px;
      for (const Polyline& piece : PiecesOf(curve, on_px, off_px)) {
        canvas.Curve(piece, false, color, width_px);
      }
    }
  }
}

void DrawMark(Canvas& canvas, const Vector2d& center, double radius_px, PoseMark mark) {
  const double r = radius_px;
  const int ink_px = std::max(1, static_cast<int>(std::lround(0.28 * r)));
  const auto at = [&](double x, double y) { return Vector2d(center + r * Vector2d(x, y)); };
  switch (mark) {
    case PoseMark::kRight:
      canvas.Dot(center, r + 1, kHalo);
      canvas.Dot(center, r, kRightColor);
      canvas.Curve({at(-0.48, 0.02), at(-0.12, 0.40), at(0.50, -0.36)}, false, kMarkInk, ink_px);
      return;
    case PoseMark::kWrong: {
      const auto square = [&](double half) {
        const double h = half / r;
        return Polyline{at(-h, -h), at(h, -h), at(h, h), at(-h, h)};
      };
      canvas.Polygon(square(0.92 * r + 1), kHalo);
      canvas.Polygon(square(0.92 * r), kWrongColor);
      canvas.Curve({at(-0.45, -0.45), at(0.45, 0.45)}, false, kHalo, ink_px);
      canvas.Curve({at(-0.45, 0.45), at(0.45, -0.45)}, false, kHalo, ink_px);
      return;
    }
    case PoseMark::kUnknown:
      canvas.Ring(center, 0.8 * r, kHalo, ink_px + 2);
      canvas.Ring(center, 0.8 * r, kUnjudgedColor, ink_px);
      return;
  }
}

Vector2d PlateSize(const Plate& plate) {
  const double r = IconRadius(plate), edge_px = 0.45 * r;
  double width_px = 2 * edge_px;
  if (plate.mark != PoseMark::kUnknown) width_px += 2 * r;
  if (!plate.text.empty()) width_px += TextWidth(plate.text, plate.text_size) + 0.5 * r;
  return {width_px, 2 * r + 2 * 0.3 * r};
}

void DrawPlate(Canvas& canvas, const Plate& plate, const Vector2d& center) {
  const Vector2d size_px = PlateSize(plate);
  const double r = IconRadius(plate), edge_px = 0.45 * r;
  const Vector2d corner = center - 0.5 * size_px;
  const auto whole = [](double v) { return static_cast<int>(std::lround(v)); };
  canvas.Shade(whole(corner.x()), whole(corner.y()), whole(size_px.x()), whole(size_px.y()), kPlate,
               kPlateOpacity);
  double x = corner.x() + edge_px;
  if (plate.mark != PoseMark::kUnknown) {
    DrawMark(canvas, {x + r, center.y()}, r, plate.mark);
    x += 2.5 * r;
  }
  canvas.Text(plate.text, whole(x), whole(center.y() + 10.5 * plate.text_size), kMarkInk,
              plate.text_size);
}

Image<Rgb8> WithKey(const Image<Rgb8>& picture, const std::vector<KeyEntry>& entries) {
  constexpr int kLine_px = 26, kGap_px = 24, kMargin_px = 12, kTop_px = 8;
  constexpr int kSample_px = 46;
  constexpr Rgb8 kGround{92, 104, 120};  // similar to the bin
  const auto sample_px = [](const KeyEntry& entry) {
    return entry.sample == KeyEntry::Sample::kNone ? 0 : kSample_px + 8;
  };
  std::vector<int> widths_px;
  for (const KeyEntry& entry : entries) {
    widths_px.push_back(sample_px(entry) + TextWidth(entry.meaning, kKeyText));
  }
  const std::vector<FlowPlace> places = FlowPlaces(widths_px, picture.width(), kMargin_px, kGap_px);
  const int strip_px = places.empty() ? 0 : (places.back().line + 1) * kLine_px + 2 * kTop_px;
  Canvas canvas(picture.width(), picture.height() + strip_px, kKeyPaper);
  canvas.Paste(picture, 0, 0);
  for (size_t i = 0; i < entries.size(); ++i) {
    const KeyEntry& entry = entries[i];
    const int left = places[i].x;
    const int y = picture.height() + kTop_px + places[i].line * kLine_px + kLine_px / 2;
    if (entry.sample != KeyEntry::Sample::kNone) {
      canvas.Shade(left, y - 10, kSample_px, 21, kGround, 1);
      DrawCurves(canvas, {{Vector2d(left + 4, y), Vector2d(left + kSample_px - 5, y)}},
                 entry.stroke);
    }
    if (entry.sample == KeyEntry::Sample::kMark) {
      DrawMark(canvas, Vector2d(left + 0.5 * (kSample_px - 1), y), 7, entry.mark);
    }
    canvas.TextWithin(picture.width() - left - sample_px(entry) - 4, entry.meaning,
                      left + sample_px(entry), y + 5, kKeyInk, kKeyText);
  }
  return canvas.Take();
}

}  // namespace pickbed::eval
