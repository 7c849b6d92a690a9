#include "perception/features/codebook.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "perception/features/neighbors.h"
#include "perception/model/pose_distance.h"
#include "scenes/base/error.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

constexpr int kLength = 64;
constexpr double kSideM = 0.064;

// Substitute for the network: means over 4 x 4 blocks of depth. Similar patches give similar
// descriptors.
std::vector<float> BlockMeans(std::span<const int8_t> patches) {
  std::vector<float> rows(patches.size() / kPatchValues * kLength, 0);
  for (size_t i = 0; i < patches.size() / kPatchValues; ++i) {
    for (int p = 0; p < kPatchArea; ++p) {
      const int block = p / kPatchPixels / 4 * 8 + p % kPatchPixels / 4;
      rows[i * kLength + block] += patches[i * kPatchValues + p] / (127.0f * 16);
    }
  }
  return rows;
}

ObjectSet Brackets() { return {ObjectOf(BracketMesh())}; }

IsolatedOptions FewViews(int views) {
  IsolatedOptions options;
  options.views = views;
  options.patches_per_view = 4;
  options.distance_m = RayCastViews::kDistanceM;
  options.focal_px = SmallCamera().fx();
  return options;
}

ObjectCodes SmallBook(RayCastViews& views, int count, int threads = 1) {
  return MakeObjectCodes(views, ObjectId{0}, {kSideM}, kLength, BlockMeans, FewViews(count), 7,
                         threads, {});
}

TEST(Codebook, QueryOfAnEntryVotesForItsPose) {
  // Without noise, the same view, pixel and angle give the descriptor of the entry, and X_CP * X_PO
  // is the pose.
  RayCastViews views(Brackets(), 0.0);
  const CameraIntrinsics camera = CropCamera(0.1, FewViews(1));
  const CloudOptions keep_planes{.min_plane_share = 1};
  Rng rng(1);
  ObjectCodes codes;
  codes.length = kLength;
  std::vector<OrganizedCloud> clouds;
  std::vector<Pose> truths;
  std::vector<double> angles;
  for (int i = 0; i < 30; ++i) {
    truths.push_back(MakePose(rng.Rotation().toRotationMatrix(), {0, 0, RayCastViews::kDistanceM}));
    angles.push_back(rng.Uniform(0, 2 * std::numbers::pi));
    const LabelledView view = views.Isolated(ObjectId{0}, {truths[i]}, camera, 1).front();
    clouds.push_back(BuildCloud(view.frame, std::nullopt, keep_planes));
    const int pixel = clouds[i].foreground_pixels[clouds[i].foreground_pixels.size() / 2];
    const PatchSet cut =
        CutPatches(clouds[i], std::vector{pixel}, std::vector{angles[i]}, {kSideM});
    AppendCodes({cut.values, {cut.X_CP[0].inverse() * truths[i]}}, BlockMeans, codes);
  }
  for (int i = 0; i < 30; ++i) {
    const int pixel = clouds[i].foreground_pixels[clouds[i].foreground_pixels.size() / 2];
    const PatchSet query =
        CutPatches(clouds[i], std::vector{pixel}, std::vector{angles[i]}, {kSideM});
    const Neighbors found = SearchExactly(codes.descriptors, BlockMeans(query.values), kLength, 1);
    ASSERT_EQ(found.rows[0], i);
    const Pose X_CO = query.X_CP[0] * CodePose(codes, found.rows[0]);
    const PoseGap gap = GapBetween(X_CO, truths[i]);
    EXPECT_LT(gap.angle_deg, 0.01);
    EXPECT_LT(gap.shift_m, 1e-6);
  }
}

TEST(Codebook, NewViewVotesNearTheTruthMoreThanChance) {
  RayCastViews views(Brackets());
  const ObjectCodes codes = SmallBook(views, 600);
  const PoseEmbedding embedding(*views.objects()[0]);
  int near = 0, chance = 0, queries = 0;
  ForEachIsolatedBlock(
      views, ObjectId{0}, {kSideM}, FewViews(40), 99, [&](LabelledPatches patches, double) {
        const Neighbors found =
            SearchExactly(codes.descriptors, BlockMeans(patches.values), kLength, 5);
        for (size_t i = 0; i < patches.size(); ++i, ++queries) {
          const auto hits = [&](int row) {
            return embedding.Distance(CodePose(codes, row), patches.X_PO[i]) < 0.3;
          };
          bool any = false, any_blind = false;
          for (int k = 0; k < 5; ++k) {
            any |= hits(found.rows[i * 5 + k]);
            any_blind |= hits(static_cast<int>((i * 31 + k * 97) % codes.size()));
          }
          near += any;
          chance += any_blind;
        }
        return true;
      });
  EXPECT_GT(near, 0.4 * queries);
  EXPECT_GT(near, 3 * chance);
}

TEST(Codebook, SameSeedSameCodebook) {
  RayCastViews views(Brackets());
  const ObjectCodes first = SmallBook(views, 12), second = SmallBook(views, 12);
  EXPECT_EQ(first.descriptors, second.descriptors);
  ASSERT_EQ(first.size(), second.size());
  EXPECT_EQ(first.size(), 48u);
  for (size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first.X_PO[i], second.X_PO[i]);
}

TEST(Codebook, CodebookIsIndependentOfThreads) {
  RayCastViews views(Brackets());
  const ObjectCodes one = SmallBook(views, 600), two = SmallBook(views, 600, 2);
  EXPECT_GT(one.size(), 2000u);
  EXPECT_EQ(one.descriptors, two.descriptors);
  EXPECT_EQ(one.X_PO, two.X_PO);
}

TEST(Codebook, ErrorsOfTheDescriptorAreRethrown) {
  RayCastViews views(Brackets());
  const auto fail = [](std::span<const int8_t>) -> std::vector<float> {
    throw std::runtime_error("no memory");
  };
  for (const int threads : {1, 2}) {
    EXPECT_THROW(
        MakeObjectCodes(views, ObjectId{0}, {kSideM}, kLength, fail, FewViews(600), 7, threads, {}),
        std::runtime_error);
  }
}

TEST(CodebookContent, RoundTripKeepsTheCodebook) {
  RayCastViews views(Brackets());
  const ObjectCodes codes = SmallBook(views, 8);
  const auto read = CodesFromBytes(CodesToBytes(codes, 42), 42);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->length, codes.length);
  EXPECT_EQ(read->descriptors, codes.descriptors);
  EXPECT_EQ(read->X_PO, codes.X_PO);
}

TEST(CodebookContent, CutAndLongerContentAndListsOfOtherSizesAreRefused) {
  RayCastViews views(Brackets());
  ObjectCodes codes = SmallBook(views, 2);
  const std::string content = CodesToBytes(codes, 42);
  EXPECT_FALSE(CodesFromBytes(content, 43)) << "another key";
  for (size_t size = 0; size < content.size(); ++size) {
    EXPECT_THROW(CodesFromBytes(content.substr(0, size), 42), InputError) << "cut to " << size;
  }
  EXPECT_THROW(CodesFromBytes(content + "x", 42), InputError);
  codes.X_PO.pop_back();
  EXPECT_THROW(CodesFromBytes(CodesToBytes(codes, 42), 42), InputError);
  codes.length = 0;
  EXPECT_THROW(CodesFromBytes(CodesToBytes(codes, 42), 42), InputError);
}

}  // namespace
}  // namespace pickbed::tests
