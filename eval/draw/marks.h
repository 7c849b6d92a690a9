#pragma once

// Symbols, line styles and colors for right and wrong poses. A meaning has a symbol and a line
// style besides its color. The colors are blue and orange as in the charts, because readers with
// any kind of color vision can distinguish them (Okabe and Ito, "Color Universal Design", 2008).

#include <Eigen/Core>
#include <string>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/layer.h"

namespace pickbed::eval {

// Comparison of a pose with ground truth. kWrong includes further poses of an instance that already
// has a right one.
enum class PoseMark { kUnknown, kRight, kWrong };

inline constexpr Rgb8 kRightColor{64, 160, 255}, kWrongColor{240, 108, 5};
inline constexpr Rgb8 kUnjudgedColor{214, 218, 224}, kMissedColor{255, 255, 255};
inline constexpr Rgb8 kTargetColor{255, 236, 70};  // of the instance that was requested
Rgb8 ColorOf(PoseMark mark);

enum class LineStyle { kSolid, kDashed, kDotted };

// Appearance of a curve. A dark halo of `halo_px` on each side separates it from the background.
struct Stroke {
  Rgb8 color;
  LineStyle style = LineStyle::kSolid;
  int width_px = 2;
  int halo_px = 1;
};
// Draws closed curves. The halos of all curves are below the lines of all curves.
void DrawCurves(Canvas& canvas, const std::vector<Polyline>& curves, const Stroke& stroke);

// Draws a disc with a tick (right), a square with a cross (wrong) or a ring (unknown).
void DrawMark(Canvas& canvas, const Eigen::Vector2d& center, double radius_px, PoseMark mark);

// A text on a dark plate, after the symbol of a pose. For kUnknown there is no symbol.
struct Plate {
  PoseMark mark = PoseMark::kUnknown;
  std::string text;
  double text_size = 0.45;  // as in Canvas::Text
};
Eigen::Vector2d PlateSize(const Plate& plate);  // width and height, px
void DrawPlate(Canvas& canvas, const Plate& plate, const Eigen::Vector2d& center);

// Entry of the legend of a picture: a sample and its meaning.
struct KeyEntry {
  enum class Sample { kNone, kMark, kLine };
  std::string meaning;
  Sample sample = Sample::kNone;
  PoseMark mark = PoseMark::kUnknown;
  Stroke stroke = {};
};
// Returns the picture with these entries in a strip below it, in as many lines as necessary.
Image<Rgb8> WithKey(const Image<Rgb8>& picture, const std::vector<KeyEntry>& entries);

}  // namespace pickbed::eval
