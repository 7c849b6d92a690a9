#include "eval/draw/plot.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "eval/draw/overlay.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

TEST(DrawDepthError, ColorsDistinguishNearerFartherAndHoles) {
  const Image<float> ideal(4, 1, 1.0f);
  Image<float> seen = ideal;
  seen(1, 0) = 1.01f, seen(2, 0) = 0.995f, seen(3, 0) = 0;
  const Image<Rgb8> error = DrawDepthError(ideal, seen, 0.01);
  EXPECT_EQ(error(0, 0), (Rgb8{255, 255, 255}));
  EXPECT_GT(error(1, 0).r, error(1, 0).b + 250);
  EXPECT_EQ(error(2, 0).b, 255);
  EXPECT_NEAR(error(2, 0).r, 128, 2);
  EXPECT_EQ(error(3, 0), Rgb8{});
}

TEST(DrawChart, PointHeightIsLinearInItsValue) {
  const Rgb8 red{255, 0, 0};
  const auto height_of_dot = [&](double y) {
    const Chart chart{
        "x", "y", {{"", {{0, 0}, {1, 10}}, {0, 0, 255}}, {"", {{0.5, y}}, red, true}}};
    const Image<Rgb8> image = DrawChart(chart, 300, 200);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < 200; ++v) {
      for (int u = 0; u < 300; ++u) {
        if (image(u, v) == red) sum += v, ++count;
      }
    }
    return count > 0 ? sum / count : -1;
  };
  const double at_2 = height_of_dot(2), at_5 = height_of_dot(5), at_8 = height_of_dot(8);
  EXPECT_GT(at_8, 0);
  EXPECT_NEAR(at_2 - at_5, at_5 - at_8, 1.5);
  EXPECT_GT(at_2 - at_8, 60);
}

TEST(PlotAxis, MapsItsEndsAndBack) {
  const PlotAxis axis(-2, 6, 100, 20);
  EXPECT_DOUBLE_EQ(axis.At(-2), 100);
  EXPECT_DOUBLE_EQ(axis.At(6), 20);
  EXPECT_DOUBLE_EQ(axis.ValueAt(axis.At(1.5)), 1.5);
  EXPECT_THROW(PlotAxis(1, 1, 0, 10), std::logic_error);
}

// Pixels of a column of the chart: bluish ones (line and band), and ones of the marked range.
struct Column {
  int blue = 0, marked = 0;
};
Column ColumnOf(const Chart& chart, int u) {
  const Image<Rgb8> image = DrawChart(chart, 300, 200);
  Column column;
  for (int v = 0; v < image.height(); ++v) {
    column.blue += image(u, v).b > image(u, v).r + 20;
    column.marked += image(u, v) == Rgb8{232, 244, 234};
  }
  return column;
}

TEST(DrawChart, FillsTheBandBetweenTheEndsOfItsIntervals) {
  Chart chart{"x", "", {{"", {{0, 0.5}, {10, 0.5}}, {0, 114, 178}}}, /*percent=*/true};
  const int line = ColumnOf(chart, 150).blue;
  chart.series[0].band = {{0.25, 0.75}, {0.25, 0.75}};
  const int half = ColumnOf(chart, 150).blue;
  chart.series[0].band = {{0, 1}, {0, 1}};
  const int whole = ColumnOf(chart, 150).blue;
  EXPECT_LT(line, 6);
  EXPECT_GT(half, 50);
  EXPECT_NEAR(whole, 2 * half, 6);
}

TEST(DrawChart, TheBandBreaksAtUnknownIntervals) {
  Chart chart{"x", "", {{"", {{0, 0.5}, {4, 0.5}, {6, 0.5}, {10, 0.5}}, {0, 114, 178}}}, true};
  const Interval known{0.25, 0.75}, unknown = Interval::Unknown();
  chart.series[0].band = {known, unknown, unknown, known};
  EXPECT_LT(ColumnOf(chart, 150).blue, 6) << "between two known intervals that are no neighbors";
  chart.series[0].band = {unknown, known, known, unknown};
  EXPECT_GT(ColumnOf(chart, 160).blue, 50);
}

TEST(DrawChart, MarksOnlyTheRangeOfX) {
  Chart chart{"x", "", {{"", {{0, 0.5}, {10, 0.5}}, {0, 114, 178}}}, /*percent=*/true};
  EXPECT_EQ(ColumnOf(chart, 100).marked, 0);
  chart.marked_x = Interval{0, 5};
  EXPECT_GT(ColumnOf(chart, 100).marked, 100) << "left half";
  EXPECT_EQ(ColumnOf(chart, 250).marked, 0) << "right half";
}

}  // namespace
}  // namespace pickbed::tests
