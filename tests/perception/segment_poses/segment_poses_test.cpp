#include "perception/segment_poses/segment_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "perception/completion/completion_file.h"
#include "perception/completion/segment_window.h"
#include "perception/features/labelled_patches.h"
#include "perception/model/pose_distance.h"
#include "perception/segment_poses/volume_codebook.h"
#include "perception/segment_poses/volume_descriptor.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/perception/completion/solid_views.h"
#include "tests/perception/completion_networks/small_networks.h"
#include "tests/support/error_of.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

SegmentPoseOptions SkirtOptions() {
  SegmentPoseOptions options;
  options.completion.method = "skirt";
  options.book.views = 300;
  options.book.distance_m = RayCastViews::kDistanceM;
  options.book.focal_px = SmallCamera().fx();
  return options;
}

RayCastViews Brackets() { return RayCastViews({ObjectOf(BracketMesh())}); }

// A volume of a box with corners low and high in C.
CompletedVolume BoxVolume(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  CompletedVolume volume;
  volume.size = 32;
  volume.cell_m = 0.004f;
  volume.origin_C = {-0.064f, -0.064f, 0.436f};
  volume.occupancy.assign(32 * 32 * 32, 0);
  for (int z = 0; z < 32; ++z) {
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        const Eigen::Array3f p_C = volume.Center_C(x, y, z).array();
        if ((p_C > low.array()).all() && (p_C < high.array()).all()) {
          volume.occupancy[volume.Index(x, y, z)] = 1;
        }
      }
    }
  }
  return volume;
}

TEST(VolumeFrame, IsAtTheCenterOfTheMatterAndLooksAlongTheRay) {
  const CompletedVolume box = BoxVolume({0.016f, -0.020f, 0.460f}, {0.056f, 0.020f, 0.500f});
  const std::optional<Pose> X_CF = VolumeFrame(box);
  ASSERT_TRUE(X_CF);
  const Eigen::Vector3d center_C(0.036, 0, 0.48);
  EXPECT_LT((X_CF->translation() - center_C).norm(), 1e-6);
  EXPECT_LT((X_CF->linear().col(2) - center_C.normalized()).norm(), 1e-6);
  EXPECT_FALSE(VolumeFrame(BoxVolume({1, 1, 1}, {2, 2, 2})));
}

TEST(VolumeDescriptor, FollowsAnObjectThatMovesAcrossTheImage) {
  const Pose turned = Pose(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  const CompletedVolume box = BoxVolume({-0.04f, -0.01f, 0.48f}, {0.04f, 0.01f, 0.52f});
  const Pose X_CF = *VolumeFrame(box);
  std::vector<float> straight, along, across;
  AppendVolumeDescriptor(box, X_CF, 0, 0.12, straight);
  // A frame that is turned by some angle, and a grid that is turned back.
  AppendVolumeDescriptor(box, X_CF * turned, -0.5, 0.12, along);
  AppendVolumeDescriptor(box, X_CF * turned, 0, 0.12, across);
  double same = 0, other = 0;
  for (size_t i = 0; i < straight.size(); ++i) {
    same += std::abs(straight[i] - along[i]);
    other += std::abs(straight[i] - across[i]);
  }
  EXPECT_EQ(straight.size(), size_t{kDescriptorValues});
  EXPECT_LT(same, 1e-3 * kDescriptorValues);
  EXPECT_GT(other, 0.01 * kDescriptorValues);
}

TEST(VolumeCodebook, FindsThePoseOfNewViews) {
  RayCastViews views = Brackets();
  const SegmentPoseOptions options = SkirtOptions();
  const auto completer = MakeCompleter(options.completion);
  const VolumeBook book = MakeVolumeBook(views, ObjectId(0), *completer, options.book);
  ASSERT_GT(book.size(), 250u);
  const PoseDistance distance(*views.objects()[0]);
  Rng rng(7);
  std::vector<Pose> poses;
  for (int i = 0; i < 30; ++i) {
    poses.push_back(MakePose(rng.Rotation().toRotationMatrix(),
                             {rng.Uniform(-0.03, 0.03), rng.Uniform(-0.03, 0.03), 0.5}));
  }
  int found = 0, shown = 0;
  for (const LabelledView& labelled : views.Isolated(ObjectId(0), poses, SmallCamera(), 3)) {
    SegmentView view;
    view.intrinsics = labelled.frame.intrinsics;
    view.depth_m = labelled.frame.depth_m;
    view.segment = Image<uint8_t>(view.depth_m.width(), view.depth_m.height(), 0);
    for (size_t i = 0; i < view.depth_m.size(); ++i) {
      if (labelled.ids.pixels()[i]) {
        view.segment.pixels()[i] = 1;
      } else {
        view.depth_m.pixels()[i] = 0.9f;
      }
    }
    if (SegmentPixels(view) < kMinSegmentPixels) continue;
    ++shown;
    const CompletedVolume volume = completer->Complete(view);
    const Pose X_CF = *VolumeFrame(volume);
    for (const Pose& X_FO : NearestVolumes(book, volume, X_CF, 10)) {
      if (distance(X_CF * X_FO, labelled.instances[0].X_CO) > 0.25) continue;
      ++found;
      break;
    }
  }
  EXPECT_GE(shown, 25);
  EXPECT_GE(found, 0.75 * shown);
}

TEST(VolumeCodebook, IsReadAsWrittenAndNotWithAnotherKey) {
  VolumeBook book;
  book.side_m = 0.12;
  book.values.assign(2 * kDescriptorValues, 0);
  book.values[3] = 1;
  book.X_FO = {Pose::Identity(), Translation({1, 2, 3})};
  const std::string bytes = VolumeBookToBytes(book, 5);
  const std::optional<VolumeBook> read = VolumeBookFromBytes(bytes, 5);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->values, book.values);
  EXPECT_EQ(read->side_m, book.side_m);
  EXPECT_EQ(read->X_FO[1].matrix(), book.X_FO[1].matrix());
  EXPECT_FALSE(VolumeBookFromBytes(bytes, 6));
  const auto fault_of = [](const std::string& content) {
    return ErrorOf([&] { VolumeBookFromBytes(content, 5); });
  };
  EXPECT_THAT(fault_of(bytes + "x"), HasSubstr("it is longer than its blocks"));
  EXPECT_THAT(fault_of(bytes.substr(0, bytes.size() - 8)), HasSubstr("cut short"));
  BlockReader reader(bytes);
  BlockWriter without_side;
  without_side.Put(reader.Take());
  without_side.Put("");
  EXPECT_THAT(fault_of(without_side.body()), HasSubstr("its head is damaged"));
  book.X_FO.pop_back();
  EXPECT_THAT(fault_of(VolumeBookToBytes(book, 5)), HasSubstr("do not fit together"));
  book.values.resize(kDescriptorValues);
  book.X_FO[0].translation().x() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(fault_of(VolumeBookToBytes(book, 5)), HasSubstr("a pose is not finite"));
}

// A sphere before a wall, and another one that hides a part of it.
RgbdFrame TwoSpheres(bool with_occluder) {
  const CameraIntrinsics k = TestCamera();
  RgbdFrame frame;
  frame.intrinsics = k;
  frame.depth_m = Image<float>(k.width(), k.height(), 0.9f);
  const auto add = [&](const Eigen::Vector3d& center_C, double radius_m) {
    for (int y = 0; y < k.height(); ++y) {
      for (int x = 0; x < k.width(); ++x) {
        const double z_m = SphereDepth_m(k, x, y, center_C, radius_m);
        float& pixel = frame.depth_m(x, y);
        if (z_m > 0 && z_m < pixel) pixel = static_cast<float>(z_m);
      }
    }
  };
  add({0, 0, 0.6}, 0.04);
  if (with_occluder) add({0.035, 0, 0.52}, 0.02);
  return frame;
}

TEST(SegmentPoses, OnlyOccludedSegmentsOfEnoughPixelsGetPoses) {
  RayCastViews views = Brackets();
  SegmentPoseOptions options = SkirtOptions();
  options.book.views = 20;
  const SegmentPoses proposer({views, {}, {}}, options);
  StageSeconds seconds;
  const auto count = [&](const RgbdFrame& frame) {
    const OrganizedCloud cloud = BuildCloud(frame, std::nullopt, {.min_plane_share = 0.25});
    return proposer.Propose(cloud, seconds).at(0).size();
  };
  EXPECT_EQ(count(TwoSpheres(false)), 0u);
  EXPECT_EQ(count(TwoSpheres(true)), static_cast<size_t>(options.poses));
  // The same scene at a sixth of the resolution: the segments have too few pixels.
  RgbdFrame coarse = TwoSpheres(true);
  const Image<float> fine = coarse.depth_m;
  coarse.intrinsics = {26, 20, 400.0 / 6, 400.0 / 6, 12.5, 9.5};
  coarse.depth_m = Image<float>(26, 20);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 26; ++x) coarse.depth_m(x, y) = fine(6 * x + 3, 6 * y + 3);
  }
  EXPECT_EQ(count(coarse), 0u);
}

TEST(SegmentPoses, ASecondUseReadsTheCacheAndGivesTheSamePoses) {
  const TemporaryFolder folder;
  RayCastViews views = Brackets();
  SegmentPoseOptions options = SkirtOptions();
  options.book.views = 40;
  const OrganizedCloud cloud = BuildCloud(TwoSpheres(true), std::nullopt);
  StageSeconds seconds;
  const auto first = SegmentPoses({views, folder.path(), {}}, options).Propose(cloud, seconds);
  const int calls = views.isolated_calls();
  const auto second = SegmentPoses({views, folder.path(), {}}, options).Propose(cloud, seconds);
  EXPECT_EQ(views.isolated_calls(), calls);
  ASSERT_FALSE(first.at(0).empty());
  for (size_t i = 0; i < first[0].size(); ++i) {
    EXPECT_EQ(first[0][i].X_CO.matrix(), second[0][i].X_CO.matrix());
  }
}

// A model that is trained again into the same file completes in another way.
TEST(SegmentPoses, AnotherModelInTheSameFileMakesAnotherCodebook) {
  for (const auto& [method, kind] : {std::pair("network", "implicit"), std::pair("vae", "vae")}) {
    const TemporaryFolder folder;
    RayCastViews views = Brackets();
    SegmentPoseOptions options = SkirtOptions();
    options.book.views = 4;
    options.completion.method = method;
    options.completion.model = (folder.path() / "own.net").string();
    CompletionModelInfo info;
    info.network = SmallNetwork(kind);
    info.network.rounds = 1;
    for (const int seed : {1, 1, 2}) {
      SaveCompletionModel(options.completion.model, info, CompletionNetwork(info.network, seed));
      const SegmentPoses poses({views, folder.path() / "cache", {}}, options);
    }
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path() / "cache"), {}), 2)
        << method;
  }
}

TEST(SegmentPoses, ADamagedCodebookIsReportedAndMadeAgain) {
  RayCastViews views = Brackets();
  const TemporaryFolder folder;
  SegmentPoseOptions options = SkirtOptions();
  options.book.views = 4;
  const SegmentPoses first({views, folder.path(), {}}, options);
  const std::filesystem::path file = std::filesystem::directory_iterator(folder.path())->path();
  const std::string bytes = ReadFileBytes(file);
  std::string flipped = bytes;
  flipped[bytes.size() / 2] ^= 0x40;
  std::vector<std::string> lines;
  SetCacheListener([&](const std::string& line) { lines.push_back(line); });
  for (const std::string& damaged : {flipped, bytes.substr(0, bytes.size() / 2), std::string()}) {
    WriteFileAtomically(file, damaged);
    lines.clear();
    const SegmentPoses again({views, folder.path(), {}}, options);
    EXPECT_EQ(ReadFileBytes(file), bytes);
    ASSERT_FALSE(lines.empty());
    EXPECT_THAT(lines.front(), HasSubstr(file.string()));
    EXPECT_THAT(lines.front(), HasSubstr("it is made again"));
  }
  SetCacheListener({});
}

TEST(SegmentPoses, RefusesUnknownMethodsAndModelsOfAnotherVersion) {
  const TemporaryFolder folder;
  RayCastViews views = Brackets();
  SegmentPoseOptions options = SkirtOptions();
  options.completion.method = "skrit";
  EXPECT_THAT(ErrorOf([&] { SegmentPoses({views, {}, {}}, options); }), HasSubstr("skirt"));
  options.completion.method = "network";
  options.completion.model = (folder.path() / "new.net").string();
  std::string head = "PICKCOMP";
  const uint64_t version[2] = {99, 0};
  head.append(reinterpret_cast<const char*>(version), sizeof version);
  WriteFileAtomically(options.completion.model, head);
  const std::string error = ErrorOf([&] { SegmentPoses({views, {}, {}}, options); });
  EXPECT_THAT(error, HasSubstr("new.net: it is of version 99"));
  EXPECT_EQ(error.find('\n'), std::string::npos);
}

TEST(ShapeCompleter, SeveralViewsAreCompletedAsOne) {
  CompletionOptions options;
  options.cells = 16;
  const auto completer = MakeCompleter(options);
  SegmentView none = UsualSphereView();
  none.segment = Image<uint8_t>(none.segment.width(), none.segment.height(), 0);
  const std::vector<SegmentView> views{UsualSphereView(), none, UsualSphereView(0.7f)};
  const std::vector<CompletedVolume> volumes = completer->CompleteAll(views);
  ASSERT_EQ(volumes.size(), 3u);
  EXPECT_TRUE(volumes[1].empty());
  const CompletedVolume alone = completer->Complete(views[0]);
  for (size_t i = 0; i < alone.occupancy.size(); ++i) {
    EXPECT_NEAR(volumes[0].occupancy[i], alone.occupancy[i], 1e-4);
    EXPECT_NEAR(volumes[2].occupancy[i], alone.occupancy[i], 1e-4);
  }
}

}  // namespace
}  // namespace pickbed::tests
