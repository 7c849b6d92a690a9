#pragma once

// A row-major image that owns its pixels. A depth image is an Image<float> with metres along the
// camera's z axis; 0 means no reading.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pickbed::scenes {

// An sRGB color with 8 bits per channel.
struct Rgb8 {
  uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb8&, const Rgb8&) = default;
};

// A rectangle of an image, in px.
struct ImageBox {
  int x = 0;  // first column
  int y = 0;  // first row
  int width = 0;
  int height = 0;
};

// Pixels are accessed by (x, y) = (column, row) without a range check.
template <typename T>
class Image {
 public:
  Image() = default;
  Image(int width, int height, T fill = T{})
      : width_(width), height_(height), pixels_(static_cast<size_t>(width) * height, fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return pixels_.empty(); }
  size_t size() const { return pixels_.size(); }
  bool Contains(int x, int y) const { return x >= 0 && y >= 0 && x < width_ && y < height_; }

  T& operator()(int x, int y) { return pixels_[static_cast<size_t>(y) * width_ + x]; }
  const T& operator()(int x, int y) const { return pixels_[static_cast<size_t>(y) * width_ + x]; }
  T* row(int y) { return pixels_.data() + static_cast<size_t>(y) * width_; }
  const T* row(int y) const { return pixels_.data() + static_cast<size_t>(y) * width_; }
  T* data() { return pixels_.data(); }
  const T* data() const { return pixels_.data(); }
  std::vector<T>& pixels() { return pixels_; }
  const std::vector<T>& pixels() const { return pixels_; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<T> pixels_;
};

}  // namespace pickbed::scenes
