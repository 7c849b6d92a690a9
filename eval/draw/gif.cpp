#include "eval/draw/gif.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace pickbed::eval {
namespace {

constexpr int kColors = 255;  // of the palette; the last entry means "unchanged"
constexpr uint8_t kUnchanged = 255;
constexpr int kLevels = 64;  // brightness levels per channel of the lookup table
constexpr size_t kSampledPixels = 1 << 17;
constexpr int kMaxCode = 4095;

using Color = std::array<uint8_t, 3>;

Color ToColor(const Rgb8& c) { return {c.r, c.g, c.b}; }

// A set of colors that is one palette entry.
struct ColorBox {
  std::vector<Color> colors;
  int channel = 0;    // with the largest spread
  double weight = 0;  // spread times the root of the number of colors

  explicit ColorBox(std::vector<Color> of) : colors(std::move(of)) {
    for (int c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax_element(colors.begin(), colors.end(),
                                                   [c](auto& a, auto& b) { return a[c] < b[c]; });
      const double spread = ((*high)[c] - (*low)[c]) * std::sqrt(double(colors.size()));
      if (c == 0 || spread > weight) {
        weight = spread;
        channel = c;
      }
    }
  }

  Color Mean() const {
    std::array<double, 3> sum{};
    for (const Color& color : colors) {
      for (int c = 0; c < 3; ++c) sum[c] += color[c];
    }
    Color mean;
    for (int c = 0; c < 3; ++c) {
      mean[c] = static_cast<uint8_t>(std::lround(sum[c] / static_cast<double>(colors.size())));
    }
    return mean;
  }
};

// Median cut (Heckbert, "Color Image Quantization for Frame Buffer Display", SIGGRAPH 1982).
std::vector<Color> MakePalette(std::span<const Image<Rgb8>> frames) {
  const size_t pixels = frames.size() * frames[0].size();
  const size_t step = std::max<size_t>(1, pixels / kSampledPixels);
  std::vector<Color> sampled;
  for (size_t i = 0; i < pixels; i += step) {
    sampled.push_back(ToColor(frames[i / frames[0].size()].pixels()[i % frames[0].size()]));
  }
  std::vector<ColorBox> boxes{ColorBox(std::move(sampled))};
  while (boxes.size() < kColors) {
    const auto widest = std::max_element(boxes.begin(), boxes.end(),
                                         [](auto& a, auto& b) { return a.weight < b.weight; });
    if (widest->weight == 0) break;
    std::vector<Color> colors = std::move(widest->colors);
    const int channel = widest->channel;
    std::sort(colors.begin(), colors.end(), [channel](const Color& a, const Color& b) {
      return a[channel] != b[channel] ? a[channel] < b[channel] : a < b;
    });
    // The cut must separate two values, else one side stays as wide as before.
    size_t cut = colors.size() / 2;
    const uint8_t value = colors[cut][channel];
    while (cut > 0 && colors[cut - 1][channel] == value) --cut;
    if (cut == 0) {
      while (colors[cut][channel] == value) ++cut;
    }
    std::vector<Color> upper(colors.begin() + static_cast<ptrdiff_t>(cut), colors.end());
    colors.resize(cut);
    *widest = ColorBox(std::move(colors));
    boxes.emplace_back(std::move(upper));
  }
  std::vector<Color> palette;
  for (const ColorBox& box : boxes) palette.push_back(box.Mean());
  return palette;
}

// Nearest palette entry of each color. The answers are remembered by 64 levels per channel.
class Lookup {
 public:
  explicit Lookup(const std::vector<Color>& palette)
      : palette_(palette), known_(kLevels * kLevels * kLevels, -1) {}

  uint8_t IndexOf(int r, int g, int b) {
    constexpr int kShift = 2;  // 256 values to 64 levels
    int16_t& known = known_[((r >> kShift) * kLevels + (g >> kShift)) * kLevels + (b >> kShift)];
    if (known < 0) known = Nearest((r | 2) & ~1, (g | 2) & ~1, (b | 2) & ~1);
    return static_cast<uint8_t>(known);
  }

 private:
  int16_t Nearest(int r, int g, int b) const {
    int16_t best = 0;
    int minimum = 1 << 30;
    for (size_t i = 0; i < palette_.size(); ++i) {
      const int dr = palette_[i][0] - r, dg = palette_[i][1] - g, db = palette_[i][2] - b;
      const int distance = 3 * dr * dr + 4 * dg * dg + 2 * db * db;  // the eye sees green best
      if (distance < minimum) {
        minimum = distance;
        best = static_cast<int16_t>(i);
      }
    }
    return best;
  }

  const std::vector<Color>& palette_;
  std::vector<int16_t> known_;
};

// Palette index of each pixel. A fixed pattern of small offsets (ordered dithering, Bayer, "An
// Optimum Method for Two-Level Rendition of Continuous-Tone Pictures", ICC 1973) hides the steps
// between entries. It does not move, so pixels at rest stay the same from frame to frame.
Image<uint8_t> Indexed(const Image<Rgb8>& frame, Lookup& lookup) {
  static constexpr int kBayer[4][4] = {
      {0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
  Image<uint8_t> indices(frame.width(), frame.height());
  for (int v = 0; v < frame.height(); ++v) {
    for (int u = 0; u < frame.width(); ++u) {
      const int offset = kBayer[v % 4][u % 4] / 2 - 4;
      const auto shifted = [offset](uint8_t value) { return std::clamp(value + offset, 0, 255); };
      const Rgb8 c = frame(u, v);
      indices(u, v) = lookup.IndexOf(shifted(c.r), shifted(c.g), shifted(c.b));
    }
  }
  return indices;
}

void AppendShort(std::string& bytes, int value) {
  bytes += static_cast<char>(value & 255);
  bytes += static_cast<char>(value >> 8);
}

// Variable-length LZW codes in sub-blocks of at most 255 bytes (Welch, "A Technique for
// High-Performance Data Compression", Computer 1984).
class LzwWriter {
 public:
  explicit LzwWriter(std::string& bytes) : bytes_(bytes), next_(kMaxCode + 1) {
    bytes_ += static_cast<char>(8);  // bits of a pixel
    Reset();
  }

  void Add(uint8_t pixel) {
    if (prefix_ < 0) {
      prefix_ = pixel;
      return;
    }
    int16_t& longer = next_[prefix_][pixel];
    if (longer >= 0) {
      prefix_ = longer;
      return;
    }
    Write(prefix_);
    longer = static_cast<int16_t>(count_++);
    if (count_ > (1 << bits_)) ++bits_;
    if (count_ > kMaxCode) Reset();
    prefix_ = pixel;
  }

  void Finish() {
    if (prefix_ >= 0) Write(prefix_);
    Write(kEnd);
    if (filled_ > 0) Byte(static_cast<uint8_t>(buffer_));
    Flush();
    bytes_ += '\0';
  }

 private:
  static constexpr int kClear = 256, kEnd = 257;

  // Starts a new table of codes.
  void Reset() {
    if (bits_ > 0) Write(kClear);
    bits_ = 9;
    if (count_ == 0) Write(kClear);
    count_ = kEnd + 1;
    for (auto& row : next_) row.fill(-1);
  }

  void Write(int code) {
    buffer_ |= static_cast<uint32_t>(code) << filled_;
    filled_ += bits_;
    while (filled_ >= 8) {
      Byte(static_cast<uint8_t>(buffer_));
      buffer_ >>= 8;
      filled_ -= 8;
    }
  }

  void Byte(uint8_t byte) {
    block_ += static_cast<char>(byte);
    if (block_.size() == 255) Flush();
  }

  void Flush() {
    if (block_.empty()) return;
    bytes_ += static_cast<char>(block_.size());
    bytes_ += block_;
    block_.clear();
  }

  std::string& bytes_;
  std::string block_;
  std::vector<std::array<int16_t, 256>> next_;  // code of a prefix with one more pixel, -1 = none
  int bits_ = 0, count_ = 0, prefix_ = -1, filled_ = 0;
  uint32_t buffer_ = 0;
};

// The smallest box with all pixels that differ; one pixel if there are none.
ImageBox ChangedBox(const Image<uint8_t>& before, const Image<uint8_t>& now) {
  int left = now.width(), top = now.height(), right = -1, bottom = -1;
  for (int v = 0; v < now.height(); ++v) {
    for (int u = 0; u < now.width(); ++u) {
      if (before(u, v) == now(u, v)) continue;
      left = std::min(left, u);
      right = std::max(right, u);
      top = std::min(top, v);
      bottom = std::max(bottom, v);
    }
  }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

void AppendFrame(const Image<uint8_t>* before, const Image<uint8_t>& now, int centiseconds,
                 std::string& bytes) {
  const ImageBox box =
      before != nullptr ? ChangedBox(*before, now) : ImageBox{0, 0, now.width(), now.height()};
  bytes += std::string("\x21\xf9\x04\x05", 4);  // keep the frame, with a transparent color
  AppendShort(bytes, centiseconds);
  bytes += static_cast<char>(kUnchanged);
  bytes += '\0';
  bytes += '\x2c';
  for (const int value : {box.x, box.y, box.width, box.height}) AppendShort(bytes, value);
  bytes += '\0';
  LzwWriter writer(bytes);
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      const bool same = before != nullptr && (*before)(u, v) == now(u, v);
      writer.Add(same ? kUnchanged : now(u, v));
    }
  }
  writer.Finish();
}

}  // namespace

std::string GifBytes(std::span<const Image<Rgb8>> frames, double frame_s) {
  if (frames.empty()) throw std::logic_error("a GIF needs at least one frame");
  for (const Image<Rgb8>& frame : frames) {
    if (frame.width() != frames[0].width() || frame.height() != frames[0].height()) {
      throw std::logic_error("frames of a GIF have different sizes");
    }
  }
  const std::vector<Color> palette = MakePalette(frames);
  std::string bytes = "GIF89a";
  AppendShort(bytes, frames[0].width());
  AppendShort(bytes, frames[0].height());
  bytes += std::string("\xf7\0\0", 3);  // a palette of 256 colors follows
  for (int i = 0; i < 256; ++i) {
    const Color color = i < static_cast<int>(palette.size()) ? palette[i] : Color{};
    bytes.append(reinterpret_cast<const char*>(color.data()), color.size());
  }
  bytes += std::string("\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0", 19);  // repeat forever
  const int centiseconds = std::max(2, static_cast<int>(std::lround(100 * frame_s)));
  Lookup lookup(palette);
  Image<uint8_t> before;
  for (const Image<Rgb8>& frame : frames) {
    Image<uint8_t> now = Indexed(frame, lookup);
    AppendFrame(before.empty() ? nullptr : &before, now, centiseconds, bytes);
    before = std::move(now);
  }
  return bytes + '\x3b';
}

}  // namespace pickbed::eval
