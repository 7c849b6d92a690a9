#pragma once

// Drawing on an image: lines, dots, text and tiles. Positions are in px; (0, 0) is the center of
// the first pixel. Drawing is clipped at the borders.

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

// Points of a curve in an image, px.
using Polyline = std::vector<Eigen::Vector2d>;

// Returns the color between `a` (share 0) and `b` (share 1).
Rgb8 Mixed(const Rgb8& a, const Rgb8& b, double share);

// Image with drawing functions.
class Canvas {
 public:
  Canvas(int width, int height, Rgb8 paper) : image_(width, height, paper) {}
  explicit Canvas(Image<Rgb8> image) : image_(std::move(image)) {}

  int width() const { return image_.width(); }
  int height() const { return image_.height(); }

  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Rgb8 color, int width_px = 1);
  void Curve(const Polyline& points, bool closed, Rgb8 color, int width_px = 1);
  void Polygon(const Polyline& corners, Rgb8 color);  // convex, filled
  void Dot(const Eigen::Vector2d& center, double radius_px, Rgb8 color);
  void Ring(const Eigen::Vector2d& center, double radius_px, Rgb8 color, int width_px = 1);
  void Frame(int x, int y, int width, int height, Rgb8 color, int width_px);  // drawn inwards
  void Fill(int x, int y, int width, int height, Rgb8 color);
  // Mixes a color into a rectangle, or into all pixels with the opacity (0..1) of each.
  void Shade(int x, int y, int width, int height, Rgb8 color, double opacity);
  void Blend(Rgb8 color, const std::function<double(int x, int y)>& opacity);
  // `y` is the baseline of the text. With `size` 1 letters are about 22 px high.
  void Text(const std::string& text, int x, int y, Rgb8 color, double size = 0.45);
  // Like Text, but reduces the size if the text is wider than `width_px`.
  void TextWithin(int width_px, const std::string& text, int x, int y, Rgb8 color,
                  double size = 0.45);
  // White text on a dark rim, centered; readable on any picture.
  void Label(const std::string& text, const Eigen::Vector2d& center, double size = 0.45);
  void Paste(const Image<Rgb8>& tile, int x, int y);

  Image<Rgb8> Take() { return std::move(image_); }

 private:
  Image<Rgb8> image_;
};

int TextWidth(const std::string& text, double size = 0.45);  // px

// Place of an item in lines of items.
struct FlowPlace {
  int x = 0;     // left end, px
  int line = 0;  // from 0
};
// Places items of these widths from left to right, `gap_px` apart. An item that does not fit into
// the page without its margins begins a new line.
std::vector<FlowPlace> FlowPlaces(const std::vector<int>& widths_px, int page_px, int margin_px,
                                  int gap_px);

// Meaning of a color.
struct LegendEntry {
  Rgb8 color;
  std::string meaning;
};
// Returns the picture with a legend strip below it, in as many lines as necessary.
Image<Rgb8> WithLegend(const Image<Rgb8>& picture, const std::vector<LegendEntry>& entries);

// Square of `side_px` around `center`, scaled to `tile_px`; white outside of the image.
Image<Rgb8> SquareCrop(const Image<Rgb8>& image, const Eigen::Vector2d& center, double side_px,
                       int tile_px);
// Enlarges by an integer factor, bicubic (`smooth`) or with nearest neighbor.
Image<Rgb8> Enlarged(const Image<Rgb8>& image, int factor, bool smooth);
// Reduces saturation and contrast, as a background for drawings.
Image<Rgb8> Faded(const Image<Rgb8>& image);

// Color map for 0..1: black, red, yellow, white.
Rgb8 HeatColor(double share);
// Color map for 0..1: blue, green, red (Turbo by Mikhailov).
Rgb8 TurboColor(double share);
// Gaussian blur with standard deviation `sigma_px`.
Image<float> Smoothed(const Image<float>& image, double sigma_px);

}  // namespace pickbed::eval
