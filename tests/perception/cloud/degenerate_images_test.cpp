// Each stage of the cloud on images without pixels, with one pixel or one line, or without
// readings, and on points without a volume.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/cloud/normals.h"
#include "perception/cloud/projector.h"
#include "perception/cloud/search_cloud.h"
#include "scenes/base/error.h"
#include "tests/support/degenerate_depth.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3f;
using testing::Each;
using testing::HasSubstr;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoLimit = std::numeric_limits<float>::infinity();

CameraIntrinsics CameraOf(int width, int height) {
  return {width, height, 300, 300, 0.5 * (width - 1), 0.5 * (height - 1)};
}

RgbdFrame FrameOfDepth(const Image<float>& depth_m) {
  RgbdFrame frame;
  frame.intrinsics = CameraOf(depth_m.width(), depth_m.height());
  frame.depth_m = depth_m;
  return frame;
}

// Number of normals of the plane fit at the pixels of the mask. Other pixels have none.
int NormalsOf(Image<float> depth_m, const Image<uint8_t>& mask, int window_px = 5) {
  const Image<float> before = depth_m;
  std::vector<Vector3f> normals_C(depth_m.size(), Vector3f::Ones());
  FitPlanes(CameraOf(std::max(1, depth_m.width()), std::max(1, depth_m.height())), mask,
            {.window_px = window_px}, depth_m, normals_C);
  int count = 0;
  for (size_t i = 0; i < normals_C.size(); ++i) {
    const bool has_normal = !normals_C[i].isZero(0);
    count += has_normal;
    if (has_normal) {
      EXPECT_NE(mask.data()[i], 0);
      EXPECT_NEAR(normals_C[i].norm(), 1, 1e-5f);
      EXPECT_TRUE(std::isfinite(depth_m.data()[i]) && depth_m.data()[i] > 0);
    } else if (!std::isnan(before.data()[i])) {
      EXPECT_EQ(depth_m.data()[i], before.data()[i]);
    }
  }
  return count;
}

TEST(DegeneratePlaneFits, FewOrBadReadingsHaveNoNormal) {
  EXPECT_EQ(NormalsOf({}, {}), 0);
  for (const float depth_m : {0.8f, 0.0f, -0.8f, kNotANumber, kNoLimit, 1e-42f, 1e30f}) {
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(40, 1), std::pair(1, 40)}) {
      const Image<uint8_t> all(width, height, 1);
      EXPECT_EQ(NormalsOf(Image<float>(width, height, depth_m), all), 0) << depth_m;
      EXPECT_EQ(NormalsOf(Image<float>(width, height, depth_m), all, 15), 0) << depth_m;
    }
    Image<uint8_t> one(40, 30);
    EXPECT_EQ(NormalsOf(Image<float>(40, 30, depth_m), one), 0) << depth_m;
    one(20, 15) = 1;
    EXPECT_EQ(NormalsOf(Image<float>(40, 30, depth_m), one), 0) << depth_m;
  }
  for (const float bad : {0.0f, -0.8f, kNotANumber, kNoLimit, 1e-42f}) {
    EXPECT_EQ(NormalsOf(Image<float>(40, 30, bad), Image<uint8_t>(40, 30, 1)), 0) << bad;
  }
}

TEST(DegeneratePlaneFits, APlaneHasItsNormalAtEachPixel) {
  Image<float> depth_m(40, 30, 0.8f);
  EXPECT_EQ(NormalsOf(depth_m, Image<uint8_t>(40, 30, 1)), 40 * 30);
  std::vector<Vector3f> normals_C(depth_m.size());
  FitPlanes(CameraOf(40, 30), Image<uint8_t>(40, 30, 1), {}, depth_m, normals_C);
  for (const Vector3f& normal_C : normals_C)
    EXPECT_LT((normal_C + Vector3f::UnitZ()).norm(), 1e-5f);
  for (const float z_m : depth_m.pixels()) EXPECT_NEAR(z_m, 0.8f, 1e-5f);
}

TEST(DegenerateColorEdges, ImagesWithoutEdgesHaveNoGradient) {
  EXPECT_TRUE(FindColorEdges(CameraOf(1, 1), {}).empty());
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(2, 1), std::pair(1, 2), std::pair(2, 2), std::pair(7, 1)}) {
    for (const int threads : {1, 8}) {
      const ColorEdges edges = FindColorEdges(CameraOf(width, height),
                                              Image<Rgb8>(width, height, {200, 200, 200}), threads);
      ASSERT_EQ(edges.du.size(), static_cast<size_t>(width) * height);
      for (const float slope : edges.du.pixels()) EXPECT_NEAR(slope, 0, 1e-4f);
      for (const float slope : edges.dv.pixels()) EXPECT_NEAR(slope, 0, 1e-4f);
    }
  }
}

TEST(DegenerateColorEdges, ARampOfOneRowOrColumnHasItsSlope) {
  const auto grey = [](int level) {
    const auto value = static_cast<uint8_t>(level);
    return Rgb8{value, value, value};
  };
  Image<Rgb8> row(12, 1), column(1, 12);
  for (int i = 0; i < 12; ++i) row(i, 0) = column(0, i) = grey(20 * i);
  const ColorEdges of_row = FindColorEdges(CameraOf(12, 1), row);
  const ColorEdges of_column = FindColorEdges(CameraOf(1, 12), column);
  for (int i = 2; i < 10; ++i) {
    EXPECT_NEAR(of_row.du(i, 0), 20, 1e-3f);
    EXPECT_NEAR(of_column.dv(0, i), 20, 1e-3f);
  }
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(of_row.dv(i, 0), 0, 1e-3f);
    EXPECT_NEAR(of_column.du(0, i), 0, 1e-3f);
  }
}

TEST(DegenerateDepthStatistics, ImagesWithoutPairsHaveNoError) {
  std::vector<Image<float>> images = {{}, {1, 1, 0.8f}, {1, 400, 0.8f}, {2, 400, 0.8f}};
  for (const float bad : {0.0f, -0.8f, kNotANumber, kNoLimit}) images.emplace_back(40, 40, bad);
  for (const Image<float>& image : images) {
    const DepthStatistics statistics = MeasureDepth(image);
    EXPECT_EQ(statistics.Error_m(), 0);
    EXPECT_EQ(statistics.hole_share, 0);
    EXPECT_EQ(ErrorScale(statistics), 1);
  }
}

TEST(DegenerateDepthStatistics, BadReadingsBetweenReadingsAreHoles) {
  for (const float bad : {0.0f, -0.8f, kNotANumber, kNoLimit}) {
    Image<float> depth_m(41, 40, 0.8f);
    for (int y = 0; y < 40; ++y) {
      for (int x = 10; x < 20; ++x) depth_m(x, y) = bad;
    }
    const DepthStatistics statistics = MeasureDepth(depth_m);
    EXPECT_NEAR(statistics.hole_share, 10.0 / 41, 1e-9) << bad;
    EXPECT_EQ(statistics.Error_m(), 0) << bad;
  }
}

TEST(DegenerateDepthStatistics, ScaleIsInItsRange) {
  DepthStatistics statistics;
  for (const double error_m : {0.0, 1e-300, 1e300, std::numeric_limits<double>::infinity()}) {
    statistics.noise_at_1m_m = error_m;
    EXPECT_EQ(ErrorScale(statistics), error_m < 1 ? 1 : 4) << error_m;
  }
}

TEST(DegenerateHoles, OnlyHolesInsideASurfaceAreFilled) {
  EXPECT_TRUE(FillSinglePixelHoles({}).empty());
  for (const float bad : {0.0f, -0.8f, kNotANumber, kNoLimit}) {
    EXPECT_EQ(FillSinglePixelHoles(Image<float>(1, 1, bad))(0, 0), 0) << bad;
    EXPECT_THAT(FillSinglePixelHoles(Image<float>(5, 4, bad)).pixels(), Each(0.0f)) << bad;
    // A corner has three neighbours, a side five and an inner pixel eight.
    const std::tuple<int, int, float> holes[] = {{0, 0, 0.0f}, {2, 0, 0.0f}, {2, 2, 0.8f}};
    for (const auto& [x, y, filled_m] : holes) {
      Image<float> plane(5, 5, 0.8f);
      plane(x, y) = bad;
      EXPECT_EQ(FillSinglePixelHoles(plane)(x, y), filled_m) << bad;
    }
    Image<float> one(5, 5, bad);
    one(2, 2) = 0.8f;
    const Image<float> filled = FillSinglePixelHoles(one);
    EXPECT_EQ(filled(2, 2), 0.8f);
    EXPECT_EQ(std::count(filled.pixels().begin(), filled.pixels().end(), 0.0f), 24);
  }
}

TEST(DegenerateProjection, OnlyPointsInFrontHaveAPixel) {
  for (const CameraIntrinsics& k : {CameraOf(1, 1), CameraOf(320, 240)}) {
    const Projector project(k);
    EXPECT_EQ(project({0, 0, 1e-30f}), k.height() / 2 * k.width() + k.width() / 2);
    for (const float bad : {kNotANumber, kNoLimit, -kNoLimit}) {
      EXPECT_EQ(project({bad, 0, 1}), -1);
      EXPECT_EQ(project({0, bad, 1}), -1);
    }
    for (const float z_m : {0.0f, -0.0f, -1.0f, kNotANumber, -kNoLimit}) {
      EXPECT_EQ(project({0, 0, z_m}), -1) << z_m;
    }
    EXPECT_EQ(project({1, 0, 1e-42f}), -1);
    EXPECT_EQ(project({1e38f, 1e38f, 1}), -1);
  }
}

void ExpectInImage(const PixelBox& box, const CameraIntrinsics& k) {
  EXPECT_TRUE(0 <= box.x0 && box.x0 <= box.x1 && box.x1 <= k.width());
  EXPECT_TRUE(0 <= box.y0 && box.y0 <= box.y1 && box.y1 <= k.height());
}

bool IsEmpty(const PixelBox& box) { return box.x0 >= box.x1 || box.y0 >= box.y1; }

TEST(DegenerateBalls, BoxesAreInTheImage) {
  const std::vector<float> places = {0,     1e-30f, -1e-30f,  0.5f,      -0.5f,
                                     1e30f, -1e30f, kNoLimit, -kNoLimit, kNotANumber};
  for (const CameraIntrinsics& k : {CameraOf(1, 1), CameraOf(320, 240)}) {
    for (const float x : places) {
      for (const float z : places) {
        for (const float radius_m : {0.0f, 1e-30f, 0.1f, 1e30f, kNoLimit, kNotANumber}) {
          for (const Vector3f& center_C : {Vector3f(x, 0, z), Vector3f(0, x, z)}) {
            const PixelBox box = BallPixels(k, center_C, radius_m);
            ExpectInImage(box, k);
            if (!center_C.allFinite() || std::isnan(radius_m)) {
              EXPECT_TRUE(IsEmpty(box)) << center_C.transpose() << " " << radius_m;
            }
          }
        }
      }
    }
  }
}

TEST(DegenerateBalls, PointsCoverTheirPixel) {
  const CameraIntrinsics k = CameraOf(320, 240);
  for (const Vector3f& p_C :
       {Vector3f(0, 0, 1), Vector3f(0.2f, -0.1f, 0.6f), Vector3f(0, 0, 1e-6f)}) {
    const PixelBox box = BallPixels(k, p_C, 0);
    const int pixel = Projector(k)(p_C), x = pixel % 320, y = pixel / 320;
    EXPECT_TRUE(box.x0 <= x && x < box.x1 && box.y0 <= y && y < box.y1) << p_C.transpose();
    EXPECT_LE((box.x1 - box.x0) * (box.y1 - box.y0), 9);
  }
  const PixelBox around = BallPixels(k, {0, 0, -0.05f}, 0.1f);
  EXPECT_EQ((around.x1 - around.x0) * (around.y1 - around.y0), 320 * 240);
  EXPECT_TRUE(IsEmpty(BallPixels(k, {0, 0, -0.2f}, 0.1f)));
  EXPECT_TRUE(IsEmpty(BallPixels(k, {9, 0, 1}, 0.1f)));
}

TEST(DegenerateBinning, LeavesAPixelOfAnyImage) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const CameraIntrinsics& k : {CameraOf(1, 1), CameraOf(320, 240)}) {
    for (const double distance_m : {0.0, 1e-300, 1e-9, 0.5, 1e300, infinity, double{kNotANumber}}) {
      for (const double diameter_m : {0.0, 1e-300, 0.1, 1e300, infinity, double{kNotANumber}}) {
        const int factor = BinningFor(k, distance_m, diameter_m);
        EXPECT_GE(factor, 1) << distance_m << " " << diameter_m;
        EXPECT_LE(factor, std::min(k.width(), k.height())) << distance_m << " " << diameter_m;
      }
    }
  }
  EXPECT_EQ(BinningFor(CameraOf(320, 240), 0.5, 0), 1);
  EXPECT_EQ(BinningFor(CameraOf(320, 240), 1e-9, 0.1), 240);
  EXPECT_EQ(SmallestDiameter_m({}), infinity);
  EXPECT_EQ(SmallestDiameter_m({std::make_shared<ObjectModel>()}), 0);
}

TEST(DegenerateBinning, ABlockWithFewReadingsHasNone) {
  for (const float bad : {0.0f, -0.8f, kNotANumber, kNoLimit}) {
    Image<float> depth_m(3, 3, bad);
    for (int readings = 0; readings <= 9; ++readings) {
      const RgbdFrame binned = BinnedFrame(FrameOfDepth(depth_m), 3);
      ASSERT_EQ(binned.depth_m.size(), 1u);
      EXPECT_EQ(binned.intrinsics.width(), 1);
      EXPECT_TRUE(binned.color.empty());
      EXPECT_NEAR(binned.depth_m(0, 0), readings >= 5 ? 0.8f : 0.0f, 1e-6f) << bad << readings;
      if (readings < 9) depth_m.data()[readings] = 0.8f;
    }
    EXPECT_EQ(BinnedFrame(FrameOfDepth(depth_m), 1).depth_m, depth_m);
  }
  EXPECT_THAT(ErrorOf([] { BinnedFrame(FrameOfDepth(Image<float>(3, 3, 0.8f)), 4); }),
              HasSubstr("width = 0"));
}

TEST(DegenerateClouds, ImagesOfOnePixelOrLineHaveTheirPoints) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(1, 300), std::pair(300, 1), std::pair(2, 2)}) {
    const size_t pixels = static_cast<size_t>(width) * height;
    for (const DepthCase& test : DepthCases()) {
      RgbdFrame frame = FrameOfDepth(Image<float>(width, height));
      for (size_t i = 0; i < pixels; ++i) {
        const int index = static_cast<int>(i);
        frame.depth_m.data()[i] = test.depth_m(index % width, index / width);
      }
      frame.color = Image<Rgb8>(width, height, {90, 90, 90});
      const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, {.min_plane_share = 1});
      ASSERT_EQ(cloud.points_C.size(), pixels) << test.name;
      for (size_t i = 0; i < pixels; ++i) {
        EXPECT_TRUE(cloud.points_C[i].allFinite()) << test.name;
        EXPECT_EQ(cloud.points_C[i].z(), cloud.depth_m.data()[i]) << test.name;
        EXPECT_EQ(cloud.foreground.data()[i] != 0, cloud.depth_m.data()[i] > 0) << test.name;
        EXPECT_TRUE(cloud.normals_C[i].isZero(0)) << test.name;
      }
      EXPECT_EQ(cloud.edges.du.size(), pixels) << test.name;
      EXPECT_EQ(SearchCloud(frame, std::nullopt, 1).points_C.size(), pixels) << test.name;
    }
  }
}

TEST(DegenerateClouds, ImagesWithoutPixelsAndOtherSizesAreRefused) {
  EXPECT_THAT(ErrorOf([] { BuildCloud(RgbdFrame(), std::nullopt); }),
              HasSubstr("the frame has no depth image"));
  const RgbdFrame frame = FrameOfDepth(Image<float>(40, 30, 0.8f));
  RgbdFrame other_color = frame;
  other_color.color = Image<Rgb8>(1, 1);
  const Image<uint8_t> no_region, small_region(1, 1, 1), empty_region(40, 30);
  for (const int factor : {1, 2}) {
    EXPECT_THAT(ErrorOf([&] { SearchCloud(RgbdFrame(), std::nullopt, factor); }),
                HasSubstr("the frame has no depth image"));
    EXPECT_THAT(ErrorOf([&] { SearchCloud(other_color, std::nullopt, factor); }),
                HasSubstr("color image is 1x1"));
    for (const Image<uint8_t>* region : {&no_region, &small_region}) {
      EXPECT_THAT(ErrorOf([&] { SearchCloud(frame, std::nullopt, factor, region); }),
                  HasSubstr("region of interest"));
    }
    const OrganizedCloud nothing = SearchCloud(frame, std::nullopt, factor, &empty_region);
    EXPECT_TRUE(nothing.foreground_pixels.empty());
    EXPECT_TRUE(nothing.planes.empty());
  }
}

std::vector<Vector3f> PointsOnPlane(const Vector3f& normal_C, float offset_m) {
  const Vector3f u = normal_C.unitOrthogonal(), v = normal_C.cross(u);
  std::vector<Vector3f> points;
  for (int i = -12; i <= 12; ++i) {
    for (int k = -12; k <= 12; ++k) {
      points.push_back(offset_m * normal_C + 0.01f * static_cast<float>(i) * u +
                       0.01f * static_cast<float>(k) * v);
    }
  }
  return points;
}

TEST(DegenerateBackground, CoplanarPointsAreOnePlane) {
  for (const Vector3f& direction : {Vector3f(0, 0, -1), Vector3f(0.2f, -0.5f, -1)}) {
    const Vector3f normal_C = direction.normalized();
    std::vector<Vector3f> points = PointsOnPlane(normal_C, -0.8f);
    // A plane whose points all occur twice, and with points that are not finite.
    for (const int kind : {0, 1, 2}) {
      if (kind == 1) points.insert(points.end(), points.begin(), points.begin() + 625);
      if (kind == 2) {
        for (int i = 0; i < 200; ++i) {
          points.insert(points.begin() + 3 * i, Vector3f(0, i % 2 ? kNotANumber : kNoLimit, 1));
        }
      }
      const std::vector<BackgroundPlane> planes = FitBackground(points, {});
      ASSERT_EQ(planes.size(), 1u) << kind;
      EXPECT_LT((planes[0].normal_C - normal_C).norm(), 1e-3f) << kind;
      EXPECT_NEAR(planes[0].offset_m, -0.8f, 1e-4f) << kind;
    }
  }
}

TEST(DegenerateBackground, PointsWithoutAreaHaveNoPlane) {
  const Vector3f p(0.1f, 0.2f, 0.8f);
  std::vector<Vector3f> line;
  for (int i = 0; i < 500; ++i)
    line.push_back(p + 0.001f * static_cast<float>(i) * Vector3f::UnitX());
  for (const std::vector<Vector3f>& points :
       {std::vector<Vector3f>(),
        {p},
        {p, p},
        std::vector<Vector3f>(500, p),
        line,
        std::vector<Vector3f>(500, Vector3f::Constant(kNotANumber)),
        std::vector<Vector3f>(500, Vector3f::Constant(kNoLimit))}) {
    EXPECT_TRUE(FitBackground(points, {}).empty()) << points.size();
  }
  EXPECT_TRUE(FitBackground(PointsOnPlane({0, 0, -1}, -0.8f), {.margin_m = 0}).empty());
}

}  // namespace
}  // namespace pickbed::tests
