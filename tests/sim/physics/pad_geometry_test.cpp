#include "sim/physics/pad_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector2d;

std::vector<Vector2d> Rectangle(double a, double b, const Vector2d& center) {
  std::vector<Vector2d> corners;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) corners.push_back(center + Vector2d(a * x, b * y));
  }
  return ConvexOutline(corners);
}

double ArmOf(const std::vector<Vector2d>& outline) { return PressureOn(outline).arm; }

TEST(PressureOn, CenterIsTheCentroid) {
  EXPECT_TRUE(PressureOn(Rectangle(0.02, 0.04, {0.3, -0.2})).center.isApprox(Vector2d(0.3, -0.2)));
  EXPECT_TRUE(PressureOn({{0, 0}, {3, 0}, {0, 6}}).center.isApprox(Vector2d(1, 2)));
  EXPECT_TRUE(PressureOn({{0, 0}, {3, 6}}).center.isApprox(Vector2d(1.5, 3)));
}

// Mean lever arm of a square of side a: a / 6 * (sqrt 2 + ln(1 + sqrt 2)).
TEST(PressureOn, ArmOfASquareMatchesTheFormula) {
  const double expected = 0.04 / 6 * (std::sqrt(2.0) + std::log(1 + std::sqrt(2.0)));
  EXPECT_NEAR(ArmOf(Rectangle(0.04, 0.04, {0.3, -0.2})), expected, 1e-12);
}

// Mean lever arm of a disk of radius R: 2 R / 3.
TEST(PressureOn, ArmOfARegularPolygonApproachesTheDisk) {
  std::vector<Vector2d> corners;
  for (int i = 0; i < 400; ++i) {
    const double angle = 2 * std::numbers::pi * i / 400;
    corners.emplace_back(1 + 0.03 * std::cos(angle), 2 + 0.03 * std::sin(angle));
  }
  EXPECT_NEAR(ArmOf(ConvexOutline(corners)), 0.02, 1e-5);
}

TEST(PressureOn, ArmOfARectangleMatchesAGridSum) {
  constexpr int kCells = 400;
  double sum = 0;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      sum += std::hypot(((i + 0.5) / kCells - 0.5) * 0.02, ((j + 0.5) / kCells - 0.5) * 0.04);
    }
  }
  EXPECT_NEAR(ArmOf(Rectangle(0.02, 0.04, {0, 0})), sum / (kCells * kCells), 1e-7);
}

TEST(PressureOn, ArmOfALineIsAQuarterOfItsLengthAndOfAPointZero) {
  EXPECT_NEAR(ArmOf({{0, 0}, {0.03, 0.04}}), 0.0125, 1e-12);
  EXPECT_NEAR(ArmOf(Rectangle(0.05, 1e-6, {0, 0})), 0.0125, 1e-6);
  EXPECT_EQ(ArmOf({{1, 2}}), 0);
}

TEST(ConvexOutline, DropsPointsInsideOrOnAnEdge) {
  const auto outline =
      ConvexOutline({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.5}, {0.5, 0}, {1, 1}});
  EXPECT_EQ(outline.size(), 4u);
}

TEST(ClippedToRectangle, KeepsTheOverlap) {
  const auto cut =
      ConvexOutline(ClippedToRectangle(Rectangle(0.06, 0.02, {0.02, 0}), {0.03, 0.03}));
  // From x = -0.01 to 0.03.
  EXPECT_NEAR(ArmOf(cut), ArmOf(Rectangle(0.04, 0.02, {0, 0})), 1e-12);
  EXPECT_TRUE(ClippedToRectangle(Rectangle(0.01, 0.01, {0.1, 0}), {0.03, 0.03}).empty());
  const auto line = ClippedToRectangle({{-1, 0.01}, {1, 0.01}}, {0.03, 0.03});
  EXPECT_NEAR(ArmOf(ConvexOutline(line)), 0.015, 1e-12);
}

}  // namespace
}  // namespace pickbed::tests
