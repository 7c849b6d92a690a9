#include "scenes/image/image_io.h"

#include <gmock/gmock.h>

#include <limits>

#include "scenes/base/random.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

Image<Rgb8> RandomImage(int width, int height) {
  Rng rng(1);
  Image<Rgb8> image(width, height);
  for (Rgb8& p : image.pixels()) {
    const uint64_t bits = rng.Next();
    p = {static_cast<uint8_t>(bits), static_cast<uint8_t>(bits >> 8),
         static_cast<uint8_t>(bits >> 16)};
  }
  return image;
}

TEST(Png, ColorRoundTripsAndBytesAreReproducible) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(7, 5), std::pair(64, 33)}) {
    const Image<Rgb8> image = RandomImage(width, height);
    WritePng(folder.path() / "a.png", image);
    WritePng(folder.path() / "b.png", image);
    EXPECT_EQ(ReadPng(folder.path() / "a.png"), image);
    EXPECT_EQ(ReadFileBytes(folder.path() / "a.png"), ReadFileBytes(folder.path() / "b.png"));
  }
}

TEST(Png, SixteenBitImageRoundTrips) {
  const TemporaryFolder folder;
  Image<uint16_t> image(5, 3);
  for (size_t i = 0; i < image.size(); ++i) image.data()[i] = static_cast<uint16_t>(4681 * i);
  image(4, 2) = 65535;
  WritePng16(folder.path() / "d.png", image);
  EXPECT_EQ(ReadPng16(folder.path() / "d.png"), image);
}

TEST(Png, DepthIsRoundedAndInvalidValuesAreZero) {
  const TemporaryFolder folder;
  Image<float> depth(6, 1);
  const float values[] = {0.f,   0.65432f, std::numeric_limits<float>::quiet_NaN(),
                          100.f, -1.f,     6.5535f};
  std::copy(std::begin(values), std::end(values), depth.data());
  WriteDepthPng(folder.path() / "d.png", depth);
  EXPECT_THAT(ReadPng16(folder.path() / "d.png").pixels(),
              testing::ElementsAre(0, 6543, 0, 0, 0, 65535));
  WriteDepthPng(folder.path() / "d.png", depth, 1.0);
  EXPECT_EQ(ReadPng16(folder.path() / "d.png")(1, 0), 654);
}

TEST(Png, ErrorsHoldPathAndReason) {
  const TemporaryFolder folder;
  const auto missing = folder.path() / "missing.png";
  EXPECT_THAT(InputErrorOf([&] { ReadPng(missing); }), HasSubstr("missing.png': No such file"));
  const auto text = folder.Write("text.png", "no picture at all");
  EXPECT_THAT(InputErrorOf([&] { ReadPng(text); }), HasSubstr("text.png': it is no image"));
  EXPECT_THAT(InputErrorOf([&] { ReadPng16(text); }), HasSubstr("it is no image"));
  const auto empty = folder.Write("empty.png", "");
  EXPECT_THAT(InputErrorOf([&] { ReadPng(empty); }), HasSubstr("it is no image"));
  WritePng(folder.path() / "rgb.png", RandomImage(2, 2));
  EXPECT_THAT(InputErrorOf([&] { ReadPng16(folder.path() / "rgb.png"); }), HasSubstr("16 bits"));
  const auto nowhere = folder.path() / "no" / "such" / "a.png";
  EXPECT_THAT(InputErrorOf([&] { WritePng(nowhere, RandomImage(2, 2)); }), HasSubstr("No such"));
  EXPECT_THAT(InputErrorOf([&] { WritePng(folder.path() / "a.png", {}); }), HasSubstr("no pixels"));
}

TEST(DecodeImage, RefusesBytesThatAreNoImage) {
  const TemporaryFolder folder;
  EXPECT_THAT(InputErrorOf([] { DecodeImage(""); }), HasSubstr("it is no image"));
  EXPECT_THAT(InputErrorOf([] { DecodeImage("something else"); }), HasSubstr("it is no image"));
  const Image<Rgb8> image = RandomImage(3, 4);
  WritePng(folder.path() / "a.png", image);
  EXPECT_EQ(DecodeImage(ReadFileBytes(folder.path() / "a.png")), image);
}

// Returns the mean of each channel.
Eigen::Vector3d MeanColor(const Image<Rgb8>& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rgb8& p : image.pixels()) sum += Eigen::Vector3d(p.r, p.g, p.b);
  return sum / static_cast<double>(image.size());
}

TEST(Narrowed, KeepsAspectRatioAndMeanColor) {
  const Image<Rgb8> image = RandomImage(120, 90);
  const Image<Rgb8> narrowed = Narrowed(image, 40);
  EXPECT_EQ(narrowed.width(), 40);
  EXPECT_EQ(narrowed.height(), 30);
  EXPECT_LT((MeanColor(narrowed) - MeanColor(image)).norm(), 1);
  EXPECT_EQ(Narrowed(image, 120), image);
  EXPECT_EQ(Narrowed(RandomImage(50, 1), 2).height(), 1);
}

TEST(EncodeJpeg, ReadsBackWithSmallError) {
  Image<Rgb8> ramp(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      ramp(x, y) = {static_cast<uint8_t>(4 * x), static_cast<uint8_t>(5 * y), 30};
    }
  }
  const Image<Rgb8> back = DecodeImage(EncodeJpeg(ramp, 90));
  ASSERT_EQ(back.width(), 64);
  EXPECT_LT((MeanColor(back) - MeanColor(ramp)).norm(), 2);
  EXPECT_GT(back(60, 5).r, back(3, 5).r + 150);
  EXPECT_LT(EncodeJpeg(ramp, 20).size(), EncodeJpeg(ramp, 95).size());
}

// Zeros compress well: the file has less than a megabyte.
TEST(ReadPng, RefusesAnImageThatIsTooLargeForMemory) {
  const TemporaryFolder folder;
  std::string png = EncodePng(Image<uint16_t>(8, 8), 3);
  const auto set = [&](size_t at, uint32_t number) {
    for (int i = 0; i < 4; ++i) png[at + i] = static_cast<char>(number >> (24 - 8 * i));
  };
  set(16, 30000);
  set(20, 30000);
  const std::string path = folder.Write("large.png", png);
  EXPECT_THAT(InputErrorOf([&] { ReadPng16(path); }), HasSubstr("more than 67 million pixels"));
  set(16, 0xffffffff);
  set(20, 0xffffffff);
  EXPECT_THAT(InputErrorOf([&] { ReadPng(folder.Write("larger.png", png)); }),
              HasSubstr("more than 67 million pixels"));
}

}  // namespace
}  // namespace pickbed::tests
