#pragma once

// Drawing on an image: lines, dots, text and tiles. Places are in pixels, (0, 0) the centre of the
// first; what is outside is cut off.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/image.h"

namespace pickbed {

class Canvas {
 public:
  Canvas(int width, int height, Rgb8 paper) : image_(width, height, paper) {}
  explicit Canvas(Image<Rgb8> image) : image_(std::move(image)) {}

  int width() const { return image_.width(); }
  int height() const { return image_.height(); }

  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Rgb8 color, int width_px = 1);
  void Dot(const Eigen::Vector2d& center, double radius_px, Rgb8 color);
  void Ring(const Eigen::Vector2d& center, double radius_px, Rgb8 color, int width_px = 1);
  void Frame(int x, int y, int width, int height, Rgb8 color, int width_px);  // inwards
  void Fill(int x, int y, int width, int height, Rgb8 color);
  // `y` is the line that letters stand on; `size` 1 is some 22 px high.
  void Text(const std::string& text, int x, int y, Rgb8 color, double size = 0.45);
  // The same, smaller where it would be wider than this.
  void TextWithin(int width_px, const std::string& text, int x, int y, Rgb8 color,
                  double size = 0.45);
  // White on a dark rim, centred: to be read on any picture.
  void Label(const std::string& text, const Eigen::Vector2d& center, double size = 0.45);
  void Paste(const Image<Rgb8>& tile, int x, int y);

  Image<Rgb8> Take() { return std::move(image_); }

 private:
  Image<Rgb8> image_;
};

int TextWidth(const std::string& text, double size = 0.45);  // px

// What each colour means.
struct LegendEntry {
  Rgb8 color;
  std::string meaning;
};
// The picture over a strip that explains its colours, in as many lines as they need.
Image<Rgb8> WithLegend(const Image<Rgb8>& picture, const std::vector<LegendEntry>& entries);

// The `side_px` wide square about `center`, as a tile of tile_px; white where it leaves the image.
Image<Rgb8> SquareCrop(const Image<Rgb8>& image, const Eigen::Vector2d& center, double side_px,
                       int tile_px);
Image<Rgb8> Enlarged(const Image<Rgb8>& image, int factor, bool smooth);
// Nearly without colour and paler, for drawing on.
Image<Rgb8> Faded(const Image<Rgb8>& image);

// Black through red and yellow to white, for 0..1.
Rgb8 HeatColor(double share);
// Blue through green to red, for 0..1 (Mikhailov's Turbo).
Rgb8 TurboColor(double share);
// A Gaussian of this standard deviation.
Image<float> Smoothed(const Image<float>& image, double sigma_px);

}  // namespace pickbed
