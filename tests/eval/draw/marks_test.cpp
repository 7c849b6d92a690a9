#include "eval/draw/marks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/image/srgb.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// Colors as seen without the cones for green or red (Machado, Oliveira and Fernandes, "A
// Physiologically-based Model for Simulation of Color Vision Deficiency", 2009).
const Eigen::Matrix3d kDeuteranopia = (Eigen::Matrix3d() << 0.367322, 0.860646, -0.227968, 0.280085,
                                       0.672501, 0.047413, -0.011820, 0.042940, 0.968881)
                                          .finished();
const Eigen::Matrix3d kProtanopia = (Eigen::Matrix3d() << 0.152286, 1.052583, -0.204868, 0.114503,
                                     0.786281, 0.099216, -0.003882, -0.048116, 1.051998)
                                        .finished();

// CIELAB of a linear color, white point D65.
Eigen::Vector3d LabOf(const Eigen::Vector3d& linear) {
  const Eigen::Matrix3d to_xyz =
      (Eigen::Matrix3d() << 0.4124, 0.3576, 0.1805, 0.2126, 0.7152, 0.0722, 0.0193, 0.1192, 0.9505)
          .finished();
  const Eigen::Vector3d xyz =
      (to_xyz * linear.cwiseMax(0).cwiseMin(1)).cwiseQuotient(Eigen::Vector3d(0.9505, 1, 1.089));
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double x = f(xyz.x()), y = f(xyz.y()), z = f(xyz.z());
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

// Distance of two colors for a reader whose vision is `sees` (CIE 1976); 2 is just noticeable.
double Distance(const Rgb8& a, const Rgb8& b, const Eigen::Matrix3d& sees) {
  const auto linear = [](const Rgb8& c) {
    return Eigen::Vector3d(LinearOfSrgb(c.r / 255.0f), LinearOfSrgb(c.g / 255.0f),
                           LinearOfSrgb(c.b / 255.0f));
  };
  return (LabOf(sees * linear(a)) - LabOf(sees * linear(b))).norm();
}

TEST(MarkColors, DifferForAllKindsOfColorVision) {
  const std::vector<Rgb8> colors{kRightColor, kWrongColor, kTargetColor, kMissedColor};
  for (const Eigen::Matrix3d& sees :
       {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), kDeuteranopia, kProtanopia}) {
    EXPECT_GT(Distance(kRightColor, kWrongColor, sees), 80);
    for (size_t i = 0; i < colors.size(); ++i) {
      for (size_t k = 0; k < i; ++k) EXPECT_GT(Distance(colors[i], colors[k], sees), 25) << i << k;
    }
  }
  // A green and a red of equal brightness would fail.
  EXPECT_LT(Distance({120, 140, 60}, {180, 120, 60}, kDeuteranopia), 25);
}

Image<uint8_t> GreyOf(const Image<Rgb8>& image) {
  Image<uint8_t> grey(image.width(), image.height());
  for (size_t i = 0; i < image.size(); ++i) {
    const Rgb8 c = image.data()[i];
    grey.data()[i] = static_cast<uint8_t>(std::lround(0.299 * c.r + 0.587 * c.g + 0.114 * c.b));
  }
  return grey;
}

TEST(DrawMark, RightAndWrongDifferWithoutColor) {
  const auto drawn = [](PoseMark mark) {
    Canvas canvas(40, 40, {128, 128, 128});
    DrawMark(canvas, {20, 20}, 12, mark);
    return GreyOf(canvas.Take());
  };
  const Image<uint8_t> right = drawn(PoseMark::kRight), wrong = drawn(PoseMark::kWrong);
  // A square has corners, a disc has none.
  EXPECT_EQ(right(10, 10), 128);
  EXPECT_NE(wrong(10, 10), 128);
  int different = 0;
  for (size_t i = 0; i < right.size(); ++i) {
    different += std::abs(right.data()[i] - wrong.data()[i]) > 60;
  }
  EXPECT_GT(different, 80);
}

TEST(DrawCurves, DashedLineHasGapsAndSolidLineHasNone) {
  const auto drawn_of = [](LineStyle style) {
    Canvas canvas(240, 60, {128, 128, 128});
    DrawCurves(canvas, {{{20, 20}, {220, 20}, {220, 40}, {20, 40}}}, {kRightColor, style, 2, 1});
    const Image<Rgb8> image = canvas.Take();
    int drawn = 0;
    for (int x = 30; x < 210; ++x) drawn += image(x, 20) == kRightColor;
    return drawn;
  };
  EXPECT_EQ(drawn_of(LineStyle::kSolid), 180);
  EXPECT_LT(drawn_of(LineStyle::kDashed), 170);
  EXPECT_LT(drawn_of(LineStyle::kDotted), drawn_of(LineStyle::kDashed));
  EXPECT_GT(drawn_of(LineStyle::kDotted), 30);
}

// The line is light, its halo dark: one of them differs from any background.
TEST(DrawCurves, LineIsVisibleOnEachBackground) {
  for (const Rgb8 paper : {Rgb8{255, 255, 255}, Rgb8{0, 0, 0}, kRightColor, Rgb8{128, 128, 128}}) {
    Canvas canvas(60, 60, paper);
    DrawCurves(canvas, {{{10, 30}, {50, 30}}}, {kRightColor});
    const Image<Rgb8> image = canvas.Take();
    int strongest = 0;
    for (int y = 20; y < 40; ++y) {
      const Rgb8 c = image(30, y);
      strongest = std::max(
          strongest, std::abs(c.r - paper.r) + std::abs(c.g - paper.g) + std::abs(c.b - paper.b));
    }
    EXPECT_GT(strongest, 200);
  }
}

TEST(WithKey, KeepsThePictureAndAddsAStrip) {
  const Image<Rgb8> picture(300, 100, {10, 200, 30});
  EXPECT_EQ(WithKey(picture, {}), picture);
  const Image<Rgb8> with = WithKey(picture, {{"right: 3", KeyEntry::Sample::kMark}});
  EXPECT_EQ(with.width(), 300);
  ASSERT_GT(with.height(), 120);
  EXPECT_EQ(with(299, 99), (Rgb8{10, 200, 30}));
  // Entries that do not fit into one line go to the next.
  const std::vector<KeyEntry> many(6, {"some words about it"});
  EXPECT_GT(WithKey(picture, many).height(), with.height());
}

}  // namespace
}  // namespace pickbed::tests
