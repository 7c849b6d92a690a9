#include "eval/bop/targets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/bop/check_dataset.h"
#include "eval/bop/dataset_scores.h"
#include "eval/bop/layout.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class BopTargetsTest : public testing::Test {
 protected:
  // The data set is made once, because it is made in forked processes.
  static void SetUpTestSuite() {
    made_ = new TemporaryFolder;
    MakeSmall(made_->path(), 1, 3);
  }
  static void TearDownTestSuite() { delete made_; }
  BopTargetsTest() { fs::copy(made_->path(), root(), fs::copy_options::recursive); }
  fs::path root() const { return folder_.path() / "set"; }
  fs::path scene() const { return root() / "test" / "000001"; }
  void Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(root() / name, text);
  }
  std::vector<DatasetEstimate> Truth(const std::string& sensor = "") const {
    std::vector<DatasetEstimate> estimates;
    for (const auto& [id, image] : ReadSceneTruth(scene(), 1, ThrowFault, sensor).images) {
      for (const DatasetInstance& instance : image.instances) {
        estimates.push_back({1, id, instance.object_id, 1.0, instance.X_CO});
      }
    }
    return estimates;
  }
  // Copies the files of the scene to the names of a sensor.
  void CopyToSensor(const std::string& sensor) const {
    for (const char* name : {"scene_camera.json", "scene_gt.json", "scene_gt_info.json", "rgb",
                             "depth", "mask", "mask_visib"}) {
      fs::copy(scene() / name, scene() / OfSensor(name, sensor), fs::copy_options::recursive);
    }
  }
  void RemovePlainFiles() const {
    for (const char* name : {"scene_camera.json", "scene_gt.json", "scene_gt_info.json", "rgb",
                             "depth", "mask", "mask_visib"}) {
      fs::remove_all(scene() / name);
    }
  }

  static TemporaryFolder* made_;
  TemporaryFolder folder_;
};
TemporaryFolder* BopTargetsTest::made_ = nullptr;

TEST_F(BopTargetsTest, ImagesHaveTheOrderOfTheDetectionTargets) {
  Write("test_targets_bop24.json", R"([{"scene_id": 1, "im_id": 2}, {"scene_id": 1, "im_id": 0}])");
  const SplitTargets targets = TargetsOf(root(), "test");
  ASSERT_GE(targets.order.size(), 2);
  EXPECT_EQ(targets.order[0], (ListedImage{1, 2}));
  EXPECT_EQ(targets.order[1], (ListedImage{1, 0}));
  size_t images = 0;
  for (const auto& [scene_id, of_scene] : targets.scenes) images += of_scene.size();
  EXPECT_EQ(targets.order.size(), images);
}

TEST_F(BopTargetsTest, ImagesListedWithoutObjectCountTheirVisibleInstances) {
  const SplitTargets listed = TargetsOf(root(), "test");
  Write("test_targets_bop19.json", R"([{"scene_id": 1, "im_id": 0}, {"scene_id": 1, "im_id": 2}])");
  const SplitTargets counted = TargetsOf(root(), "test");
  for (const int image : {0, 2}) {
    EXPECT_TRUE(counted.scenes.at(1).at(image).localised);
    EXPECT_EQ(counted.scenes.at(1).at(image).counts, listed.scenes.at(1).at(image).counts);
  }
  EXPECT_FALSE(counted.scenes.at(1).at(1).localised);
  ASSERT_EQ(counted.notes.size(), 1u);
  EXPECT_THAT(counted.notes[0], HasSubstr("without obj_id"));
}

TEST_F(BopTargetsTest, FirstViewOfAMultiViewTargetIsATarget) {
  fs::remove(root() / "test_targets_bop24.json");
  Write(MultiViewTargetsFileName("test"),
        R"([{"scene_id": 1, "im_id": [["default", 2], ["left", 0]]}])");
  const std::vector<DatasetTarget> read =
      ReadTargets(root() / MultiViewTargetsFileName("test"), ThrowFault);
  ASSERT_EQ(read.size(), 1u);
  ASSERT_EQ(read[0].views.size(), 2u);
  EXPECT_EQ(read[0].image_id, 2);
  EXPECT_EQ(read[0].views[0].sensor, "");
  EXPECT_EQ(read[0].views[1].sensor, "left");
  EXPECT_EQ(read[0].views[1].image_id, 0);
  const SplitTargets targets = TargetsOf(root(), "test");
  EXPECT_TRUE(targets.scenes.at(1).at(2).detected);
  EXPECT_FALSE(targets.scenes.at(1).at(0).detected);
  CopyToSensor("left");
  CopyToSensor("right");
  const SplitTargets left = TargetsOf(root(), "test", "left");
  EXPECT_TRUE(left.scenes.at(1).at(0).detected);
  EXPECT_FALSE(left.scenes.at(1).at(2).detected);
  const SplitTargets right = TargetsOf(root(), "test", "right");
  for (const auto& [image, of_image] : right.scenes.at(1)) {
    EXPECT_FALSE(of_image.detected) << "no target has a view of this camera: " << image;
  }
  EXPECT_DOUBLE_EQ(EvaluateDataset(root(), "test", Truth()).ap_mssd, 1);

  for (const char* broken :
       {R"([{"scene_id": 1, "im_id": []}])", R"([{"scene_id": 1, "im_id": [["default"]]}])",
        R"([{"scene_id": 1, "im_id": [[0, "default"]]}])"}) {
    Write(MultiViewTargetsFileName("test"), broken);
    EXPECT_THAT(ErrorOf([&] { TargetsOf(root(), "test"); }), HasSubstr("target 0")) << broken;
  }
}

TEST_F(BopTargetsTest, TranslationsInMetresAreNoted) {
  std::vector<DatasetEstimate> estimates = Truth();
  EXPECT_THAT(EvaluateDataset(root(), "test", estimates).notes, testing::IsEmpty());
  for (DatasetEstimate& estimate : estimates) estimate.X_CO.translation() *= 1e-3;
  const std::vector<std::string> notes = EvaluateDataset(root(), "test", estimates).notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], HasSubstr("t must be in millimetres"));
}

TEST_F(BopTargetsTest, FilesOfASensorHaveItsName) {
  EXPECT_EQ(OfSensor("scene_gt.json", "left"), "scene_gt_left.json");
  EXPECT_EQ(OfSensor("depth", "left"), "depth_left");
  EXPECT_EQ(OfSensor("depth", ""), "depth");
  const std::vector<DatasetEstimate> truth = Truth();
  const double wanted = EvaluateDataset(root(), "test", truth).wanted;
  CopyToSensor("left");
  EXPECT_EQ(SensorsOf(scene()), (std::vector<std::string>{"", "left"}));
  EXPECT_EQ(ReadSceneTruth(scene(), 1, ThrowFault).sensor, "") << "the plain files come first";
  EXPECT_THAT(CheckDataset(root()).faults, testing::IsEmpty());
  fs::remove(scene() / "depth_left" / "000001.png");
  ASSERT_EQ(CheckDataset(root()).faults.size(), 1u);
  EXPECT_THAT(CheckDataset(root()).faults[0], HasSubstr("depth_left/000001.png: is missing"));
  fs::copy(scene() / "depth" / "000001.png", scene() / "depth_left" / "000001.png");
  ScoreOptions left;
  left.sensor = "left";
  EXPECT_DOUBLE_EQ(EvaluateDataset(root(), "test", truth, left).ar(), 1);

  RemovePlainFiles();
  const DatasetScores only = EvaluateDataset(root(), "test", Truth());
  EXPECT_DOUBLE_EQ(only.ar(), 1) << "the only sensor needs no choice";
  EXPECT_EQ(only.wanted, wanted);
  fs::copy(scene() / "scene_camera_left.json", scene() / "scene_camera_right.json");
  EXPECT_THAT(ErrorOf([&] { EvaluateDataset(root(), "test", truth); }),
              HasSubstr("has the sensors left, right; choose a camera"));
  ScoreOptions unknown;
  unknown.sensor = "top";
  EXPECT_THAT(ErrorOf([&] { EvaluateDataset(root(), "test", truth, unknown); }),
              HasSubstr("no files of a sensor top"));
}

}  // namespace
}  // namespace pickbed::tests
