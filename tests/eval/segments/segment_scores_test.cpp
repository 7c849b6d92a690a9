#include "eval/segments/segment_scores.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "scenes/base/random.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr int kSide = 24;

// Rectangles of random labels, some pixels without a label.
Image<uint16_t> RandomLabels(Rng& rng, int labels) {
  Image<uint16_t> image(kSide, kSide);
  for (int i = 0; i < 3 * labels; ++i) {
    const int x0 = rng.Index(kSide), y0 = rng.Index(kSide);
    const auto label = static_cast<uint16_t>(rng.Index(labels + 1));
    for (int y = y0; y < std::min(kSide, y0 + 8); ++y) {
      for (int x = x0; x < std::min(kSide, x0 + 8); ++x) image(x, y) = label;
    }
  }
  return image;
}

Image<uint16_t> Relabelled(Image<uint16_t> image, const std::vector<uint16_t>& by_label) {
  for (uint16_t& label : image.pixels()) {
    if (label > 0) label = by_label[label];
  }
  return image;
}

TEST(ScoreSegments, EqualLabelsArePerfect) {
  Rng rng(1);
  const Image<uint16_t> truth = RandomLabels(rng, 4);
  const SegmentScores scores = ScoreSegments(truth, truth);
  EXPECT_EQ(scores.weighted_overlap, 1);
  EXPECT_EQ(scores.over, 0);
  EXPECT_EQ(scores.under, 0);
  EXPECT_EQ(scores.under_error, 0);
  EXPECT_EQ(scores.matched_75, scores.segments);
  for (const SegmentedInstance& instance : scores.instances) {
    EXPECT_EQ(instance.iou, 1);
    EXPECT_EQ(instance.segments, 1);
    EXPECT_EQ(instance.in_segment, 1);
  }
}

TEST(ScoreSegments, TheNumbersOfTheLabelsHaveNoEffect) {
  Rng rng(2);
  const Image<uint16_t> truth = RandomLabels(rng, 5), labels = RandomLabels(rng, 6);
  std::vector<uint16_t> numbers(7);
  std::iota(numbers.begin(), numbers.end(), 100);
  std::reverse(numbers.begin(), numbers.end());
  const SegmentScores a = ScoreSegments(labels, truth);
  const SegmentScores b = ScoreSegments(Relabelled(labels, numbers), Relabelled(truth, numbers));
  EXPECT_DOUBLE_EQ(a.weighted_overlap, b.weighted_overlap);
  EXPECT_DOUBLE_EQ(a.under_error, b.under_error);
  EXPECT_EQ(a.matched_50, b.matched_50);
}

// The definitions, one pixel loop for each number.
TEST(ScoreSegments, AgreesWithTheDefinitionsPixelByPixel) {
  for (uint64_t seed = 10; seed < 30; ++seed) {
    Rng rng(seed);
    const Image<uint16_t> truth = RandomLabels(rng, 5), labels = RandomLabels(rng, 6);
    const auto count = [&](const auto& holds) {
      int n = 0;
      for (size_t i = 0; i < truth.size(); ++i) n += holds(truth.data()[i], labels.data()[i]);
      return n;
    };
    double all = 0, overlap = 0, error = 0;
    int matched = 0;
    std::vector<double> segment_iou(8, 0);
    for (int t = 1; t <= 5; ++t) {
      const int size = count([&](int a, int) { return a == t; });
      double best = 0;
      for (int s = 1; s <= 6; ++s) {
        const int both = count([&](int a, int b) { return a == t && b == s; });
        const int either = count([&](int a, int b) { return a == t || b == s; });
        const int outside = count([&](int a, int b) { return a != t && b == s; });
        if (both == 0) continue;
        best = std::max(best, static_cast<double>(both) / either);
        segment_iou[s] = std::max(segment_iou[s], static_cast<double>(both) / either);
        error += std::min(both, outside);
      }
      all += size;
      overlap += size * best;
    }
    for (const double iou : segment_iou) matched += iou > 0.5;
    const SegmentScores scores = ScoreSegments(labels, truth);
    EXPECT_NEAR(scores.weighted_overlap, overlap / all, 1e-12) << seed;
    EXPECT_NEAR(scores.under_error, error / all, 1e-12) << seed;
    EXPECT_EQ(scores.matched_50, matched) << seed;
  }
}

// Two halves of an image, each one instance.
TEST(ScoreSegments, SplittingIsOverAndMergingIsUnderSegmentation) {
  Image<uint16_t> truth(kSide, kSide), quarters = truth, merged = truth;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      truth(x, y) = x < kSide / 2 ? 1 : 2;
      quarters(x, y) = static_cast<uint16_t>(1 + x / (kSide / 4));
      merged(x, y) = 1;
    }
  }
  const SegmentScores split = ScoreSegments(quarters, truth);
  EXPECT_DOUBLE_EQ(split.over, 0.5);
  EXPECT_DOUBLE_EQ(split.under, 0);
  EXPECT_DOUBLE_EQ(split.weighted_overlap, 0.5);
  EXPECT_EQ(split.instances.front().segments, 2);
  const SegmentScores joined = ScoreSegments(merged, truth);
  EXPECT_DOUBLE_EQ(joined.over, 0.5) << "one instance has no segment of its own";
  EXPECT_DOUBLE_EQ(joined.under, 0.5);
  EXPECT_DOUBLE_EQ(joined.under_error, 1);
}

TEST(ScoreSegments, WithoutSegmentsNothingIsFound) {
  Rng rng(3);
  const Image<uint16_t> truth = RandomLabels(rng, 3), none(kSide, kSide);
  const SegmentScores scores = ScoreSegments(none, truth);
  EXPECT_EQ(scores.weighted_overlap, 0);
  EXPECT_EQ(scores.over, 1);
  EXPECT_EQ(scores.segments, 0);
  EXPECT_TRUE(ScoreSegments(truth, none).instances.empty());
  EXPECT_THROW(ScoreSegments(truth, Image<uint16_t>(2, 2)), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
