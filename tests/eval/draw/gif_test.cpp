#include "eval/draw/gif.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// A decoder for the GIF files of GifBytes(), written from the specification (GIF89a, appendix F).
class GifReader {
 public:
  explicit GifReader(const std::string& bytes) : bytes_(bytes) {
    EXPECT_EQ(bytes.substr(0, 6), "GIF89a");
    width_ = Short(6);
    height_ = Short(8);
    at_ = 13 + 3 * 256;
    Image<Rgb8> canvas(width_, height_);
    for (;;) {
      const uint8_t block = Byte(at_++);
      if (block == 0x3b) break;
      if (block == 0x21) {
        ReadExtension();
      } else if (block == 0x2c) {
        ReadImage(canvas);
        frames.push_back(canvas);
      } else {
        ADD_FAILURE() << "unknown block " << int(block) << " at " << at_;
        break;
      }
    }
    EXPECT_EQ(at_, bytes.size());
  }

  std::vector<Image<Rgb8>> frames;
  std::vector<int> delays_cs;
  bool repeats = false;

 private:
  uint8_t Byte(size_t at) const { return static_cast<uint8_t>(bytes_.at(at)); }
  int Short(size_t at) const { return Byte(at) | Byte(at + 1) << 8; }

  std::string SubBlocks() {
    std::string data;
    while (const uint8_t size = Byte(at_++)) {
      data += bytes_.substr(at_, size);
      at_ += size;
    }
    return data;
  }

  void ReadExtension() {
    const uint8_t label = Byte(at_++);
    const std::string data = SubBlocks();
    if (label == 0xff) repeats = data.starts_with("NETSCAPE2.0");
    if (label != 0xf9) return;
    transparent_ = data[0] & 1 ? static_cast<uint8_t>(data[3]) : -1;
    delays_cs.push_back(static_cast<uint8_t>(data[1]) | static_cast<uint8_t>(data[2]) << 8);
  }

  void ReadImage(Image<Rgb8>& canvas) {
    const int x = Short(at_), y = Short(at_ + 2), width = Short(at_ + 4), height = Short(at_ + 6);
    at_ += 9;
    const int bits = Byte(at_++);
    const std::vector<uint8_t> pixels = Unpacked(SubBlocks(), bits);
    ASSERT_EQ(pixels.size(), static_cast<size_t>(width) * height);
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i] == transparent_) continue;
      const size_t color = 13 + 3 * pixels[i];
      canvas(x + static_cast<int>(i) % width, y + static_cast<int>(i) / width) = {
          Byte(color), Byte(color + 1), Byte(color + 2)};
    }
  }

  static std::vector<uint8_t> Unpacked(const std::string& data, int bits) {
    const int clear = 1 << bits, end = clear + 1;
    std::vector<std::vector<uint8_t>> table;
    std::vector<uint8_t> pixels, last;
    int width = bits + 1;
    const auto reset = [&] {
      table.clear();
      for (int i = 0; i < clear; ++i) table.push_back({static_cast<uint8_t>(i)});
      table.resize(end + 1);
      last.clear();
      width = bits + 1;
    };
    reset();
    size_t bit = 0;
    for (;;) {
      int code = 0;
      for (int i = 0; i < width; ++i, ++bit) {
        if (bit / 8 >= data.size()) return {};
        code |= (data[bit / 8] >> (bit % 8) & 1) << i;
      }
      if (code == end) return pixels;
      if (code == clear) {
        reset();
        continue;
      }
      std::vector<uint8_t> entry;
      if (code < static_cast<int>(table.size())) {
        entry = table[code];
      } else {
        entry = last;
        entry.push_back(last.at(0));
      }
      pixels.insert(pixels.end(), entry.begin(), entry.end());
      if (!last.empty() && table.size() < 4096) {
        last.push_back(entry[0]);
        table.push_back(last);
      }
      if (table.size() == size_t(1) << width && width < 12) ++width;
      last = entry;
    }
  }

  const std::string& bytes_;
  size_t at_ = 0;
  int width_ = 0, height_ = 0, transparent_ = -1;
};

// A smooth background and a bright square that moves.
std::vector<Image<Rgb8>> MovingSquare(int count) {
  std::vector<Image<Rgb8>> frames;
  for (int f = 0; f < count; ++f) {
    Image<Rgb8>& frame = frames.emplace_back(120, 90);
    for (int y = 0; y < 90; ++y) {
      for (int x = 0; x < 120; ++x) {
        frame(x, y) = {uint8_t(2 * x), uint8_t(2 * y), uint8_t(x + y)};
        if (std::abs(x - 20 - 8 * f) < 10 && std::abs(y - 40) < 10) frame(x, y) = {250, 240, 60};
      }
    }
  }
  return frames;
}

double MeanDifference(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const Rgb8 p = a.pixels()[i], q = b.pixels()[i];
    sum += std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b);
  }
  return sum / (3.0 * static_cast<double>(a.size()));
}

TEST(Gif, FramesAreReadBackWithSimilarColors) {
  const std::vector<Image<Rgb8>> frames = MovingSquare(8);
  const std::string bytes = GifBytes(frames, 0.08);
  const GifReader read(bytes);
  ASSERT_EQ(read.frames.size(), frames.size());
  EXPECT_EQ(read.delays_cs, std::vector<int>(8, 8));
  EXPECT_TRUE(read.repeats);
  for (size_t i = 0; i < frames.size(); ++i)
    EXPECT_LT(MeanDifference(read.frames[i], frames[i]), 6);
}

// Random pixels fill the table of codes many times, so that every width of a code occurs.
TEST(Gif, NoiseIsReadBackThroughManyTables) {
  Rng rng(3);
  std::vector<Image<Rgb8>> frames(2, Image<Rgb8>(200, 150));
  for (Image<Rgb8>& frame : frames) {
    for (Rgb8& pixel : frame.pixels()) {
      pixel = rng.Next() % 2 ? Rgb8{255, 0, 0} : Rgb8{0, 0, uint8_t(40 * (rng.Next() % 6))};
    }
  }
  const GifReader read(GifBytes(frames, 0.1));
  ASSERT_EQ(read.frames.size(), 2u);
  for (size_t i = 0; i < 2; ++i) EXPECT_LT(MeanDifference(read.frames[i], frames[i]), 6);
}

TEST(Gif, FrameHoldsOnlyWhatChanged) {
  std::vector<Image<Rgb8>> still(6, MovingSquare(1)[0]);
  const size_t one = GifBytes(std::span(still).first(1), 0.1).size();
  EXPECT_LT(GifBytes(still, 0.1).size(), one + 5 * 40);
  EXPECT_EQ(GifBytes(still, 0.1), GifBytes(still, 0.1));
}

TEST(Gif, NoFramesAndDifferentSizesAreRefused) {
  EXPECT_THROW(GifBytes({}, 0.1), std::logic_error);
  const std::vector<Image<Rgb8>> frames{Image<Rgb8>(4, 4), Image<Rgb8>(4, 5)};
  EXPECT_THROW(GifBytes(frames, 0.1), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
