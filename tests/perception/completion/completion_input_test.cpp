#include "perception/completion/completion_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/completion/segment_view.h"
#include "scenes/base/error.h"
#include "tests/perception/completion/solid_views.h"

namespace pickbed::perception {
namespace {

using ::testing::HasSubstr;

TEST(CompletionInput, CubeContainsTheTrueSphereAndHasTheStatedSide) {
  const CompletionInput input(UsualSphereView());
  const CompletionCube& cube = input.cube();
  EXPECT_NEAR(cube.side_m, 1.35 * 2 * kSphereRadius_m, 0.006);
  const Eigen::Vector3f center = kSphereCenter_C.cast<float>();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(cube.origin_C[axis], center[axis] - kSphereRadius_m);
    EXPECT_GT(cube.origin_C[axis] + cube.side_m, center[axis] + kSphereRadius_m);
  }
  EXPECT_NEAR(center.z() - kSphereRadius_m - cube.origin_C.z(), 0.06 * cube.side_m, 0.001);
}

// Computes each cell anew from the equation of the sphere and the definition of the channels.
TEST(CompletionInput, ChannelsEqualABruteForceComputationOnASphere) {
  const SegmentView view = UsualSphereView();
  const CompletionInput input(view);
  const std::vector<int8_t> channels = input.Channels();
  constexpr int n = kInputCells;
  const double cell_m = input.cube().side_m / n;
  const CameraIntrinsics k = TestCamera();
  int wrong = 0, surface = 0;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const Eigen::Vector3d p_C = input.cube().origin_C.cast<double>() +
                                    cell_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const Eigen::Vector2d pixel = Project(k, p_C);
        const int u = static_cast<int>(std::lround(pixel.x()));
        const int v = static_cast<int>(std::lround(pixel.y()));
        const double seen_m = SphereDepth_m(k, u, v, kSphereCenter_C, kSphereRadius_m);
        double distance = 1, on_surface = 0, empty = 1;
        if (seen_m > 0) {
          distance = std::clamp((seen_m - p_C.z()) / (3 * cell_m), -1.0, 1.0);
          on_surface = std::abs(seen_m - p_C.z()) <= cell_m / 2;
          empty = p_C.z() < seen_m - cell_m / 2;
        }
        const size_t cell = (static_cast<size_t>(z) * n + y) * n + x;
        const size_t volume = n * n * n;
        surface += on_surface > 0;
        // A point between two pixels or two cells may be rounded to either.
        wrong += std::abs(channels[cell] - 127 * distance) > 1.5;
        wrong += channels[volume + cell] != 127 * on_surface;
        wrong += channels[2 * volume + cell] != 127 * empty;
        wrong += channels[3 * volume + cell] != 0;
      }
    }
  }
  EXPECT_LT(wrong, n * n * n / 1000);
  EXPECT_GT(surface, 300);
}

// The image shows what the camera shows: each pixel is compared with the sphere on its ray.
TEST(CompletionInput, TheImageHasTheDepthsOfTheRays) {
  const CompletionInput input(UsualSphereView());
  const std::vector<float> image = input.ImageChannels();
  ASSERT_EQ(image.size(), static_cast<size_t>(kImageChannels * kImageArea));
  const CompletionCube& cube = input.cube();
  const CameraIntrinsics k = TestCamera();
  int wrong = 0, on_segment = 0;
  for (int y = 0; y < kImagePixels; ++y) {
    for (int x = 0; x < kImagePixels; ++x) {
      // The point of the ray at the depth of the cube's center.
      const Eigen::Vector3d across((x + 0.5) / kImagePixels - 0.5, (y + 0.5) / kImagePixels - 0.5,
                                   0);
      if (across.cwiseAbs().maxCoeff() > 0.5 / kSidePerImage) continue;  // outside the cube
      const Eigen::Vector3d p_C =
          cube.origin_C.cast<double>() +
          cube.side_m * (Eigen::Vector3d::Constant(0.5) + kSidePerImage * across);
      const Eigen::Vector2d pixel = Project(k, p_C);
      const double seen_m =
          SphereDepth_m(k, static_cast<int>(std::lround(pixel.x())),
                        static_cast<int>(std::lround(pixel.y())), kSphereCenter_C, kSphereRadius_m);
      const auto at = [&](int channel) {
        return image[channel * kImageArea + y * kImagePixels + x];
      };
      const double relative =
          seen_m > 0 ? (seen_m - cube.origin_C.z()) / (0.5 * cube.side_m) - 1 : 0;
      wrong += std::abs(at(0) - relative) > 1e-3 || at(1) != (seen_m > 0) || at(2) != !(seen_m > 0);
      on_segment += seen_m > 0;
      EXPECT_EQ(at(3), 0);
      EXPECT_EQ(at(4), 0);
    }
  }
  // A point between two pixels may be rounded to either.
  EXPECT_LT(wrong, kImageArea / 100);
  EXPECT_GT(on_segment, 1000);
}

// All points of a ray have one place, and it agrees with the pixels of the image.
TEST(CompletionInput, ThePlaceInTheImageFollowsTheRay) {
  const CompletionInput input(UsualSphereView());
  const std::vector<float> image = input.ImageChannels();
  const Eigen::Vector3f center_C = kSphereCenter_C.cast<float>();
  const Eigen::Vector2f of_center = input.ImagePlace(center_C);
  EXPECT_LT((input.ImagePlace(1.2f * center_C) - of_center).norm(), 1e-5);
  Rng rng(4);
  int wrong = 0;
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d share(rng.Uniform(), rng.Uniform(), rng.Uniform());
    const Eigen::Vector3f p_C = input.cube().origin_C + input.cube().side_m * share.cast<float>();
    const Eigen::Vector2f place = input.ImagePlace(p_C);
    ASSERT_LT(place.cwiseAbs().maxCoeff(), 1);
    const Eigen::Array2i pixel = (0.5f * kImagePixels * (place.array() + 1)).cast<int>();
    const bool shows = image[kImageArea + pixel.y() * kImagePixels + pixel.x()] > 0;
    wrong += shows != (input.Facts(p_C)[3] > 0);
  }
  EXPECT_LT(wrong, 40);  // at the edge of the object
}

TEST(CompletionInput, WhatIsBehindChangesNothing) {
  const CompletionInput near(UsualSphereView(0.75f)), far(UsualSphereView(3));
  EXPECT_EQ(near.Channels(), far.Channels());
  EXPECT_EQ(near.ImageChannels(), far.ImageChannels());
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d share(rng.Uniform(), rng.Uniform(), rng.Uniform());
    const Eigen::Vector3f p_C = near.cube().origin_C + near.cube().side_m * share.cast<float>();
    EXPECT_EQ(near.Facts(p_C), far.Facts(p_C));
    EXPECT_EQ(near.IsKnownEmpty(p_C), far.IsKnownEmpty(p_C));
  }
}

TEST(CompletionInput, NoPointOfTheSphereIsKnownToBeEmpty) {
  const CompletionInput input(UsualSphereView());
  Rng rng(2);
  int inside = 0, empty = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d share(rng.Uniform(), rng.Uniform(), rng.Uniform());
    const Eigen::Vector3f p_C = input.cube().origin_C + input.cube().side_m * share.cast<float>();
    empty += input.IsKnownEmpty(p_C);
    if ((p_C.cast<double>() - kSphereCenter_C).norm() > kSphereRadius_m) continue;
    ++inside;
    EXPECT_FALSE(input.IsKnownEmpty(p_C));
  }
  EXPECT_GT(inside, 1000);
  EXPECT_GT(empty, 5000);
}

TEST(CompletionInput, AnOccluderHidesWhatIsBehindItAndABackgroundDoesNot) {
  SegmentView view = UsualSphereView();
  view.occluders = Image<uint8_t>(160, 120, 0);
  const Eigen::Vector2d center = Project(TestCamera(), kSphereCenter_C);
  for (int y = 0; y < 120; ++y) {
    for (int x = static_cast<int>(center.x()); x < 160; ++x) {
      view.depth_m(x, y) = 0.5f;
      view.segment(x, y) = 0;
      view.occluders(x, y) = 1;
    }
  }
  const CompletionInput input(view);
  const Eigen::Vector3f hidden_C = (kSphereCenter_C + Eigen::Vector3d(0.02, 0, 0)).cast<float>();
  EXPECT_FALSE(input.IsKnownEmpty(hidden_C));
  EXPECT_EQ(input.Facts(hidden_C)[5], 1);
  view.occluders = Image<uint8_t>(160, 120, 0);
  const CompletionInput as_background(view);
  EXPECT_TRUE(as_background.IsKnownEmpty(hidden_C));
}

TEST(CompletionInput, BelowAKnownFloorIsEmpty) {
  SegmentView view = UsualSphereView();
  FloorPlane floor;
  floor.normal_C = -Eigen::Vector3f::UnitZ();
  floor.offset_m = -0.6f;  // through the center of the sphere
  view.floor = floor;
  const CompletionInput input(view);
  const Eigen::Vector3f below_C(0.03f, -0.02f, 0.62f), above_C(0.03f, -0.02f, 0.58f);
  EXPECT_TRUE(input.IsKnownEmpty(below_C));
  EXPECT_FALSE(input.IsKnownEmpty(above_C));
  EXPECT_EQ(input.Facts(below_C)[8], 1);
  EXPECT_EQ(input.Facts(above_C)[8], 0);
  EXPECT_EQ(input.Facts(above_C)[7], 1);
}

TEST(CompletionInput, AcceptsASegmentThatFillsTheImage) {
  const CameraIntrinsics k(40, 40, 4000, 4000, 19.5, 19.5);
  const SegmentView view = SphereView(k, {0, 0, 0.6}, 0.04, 0.9f);
  ASSERT_EQ(SegmentPixels(view), 1600);
  const CompletionInput input(view);
  EXPECT_GT(input.cube().side_m, 0);
  const std::vector<int8_t> channels = input.Channels();
  // Cells whose pixels are outside the image have no data.
  EXPECT_EQ(channels[3 * kInputCells * kInputCells * kInputCells], 64);
}

TEST(CompletionInput, RefusesSegmentsWithoutEnoughReadings) {
  SegmentView view = UsualSphereView();
  std::fill(view.depth_m.pixels().begin(), view.depth_m.pixels().end(), NAN);
  try {
    const CompletionInput input(view);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("0 pixels with depth; a completion needs at least 50"));
  }
}

}  // namespace
}  // namespace pickbed::perception
