#include "eval/bop/make_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "eval/bop/dataset_card.h"
#include "eval/bop/dataset_scores.h"
#include "eval/bop/layout.h"
#include "eval/bop/write_scene.h"
#include "eval/cell/simulated_cell.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using ParsedJson = nlohmann::json;

// Bytes of every file below a folder, by relative path.
std::map<std::string, std::string> BytesOf(const fs::path& root) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!entry.is_regular_file()) continue;
    files[entry.path().lexically_relative(root).string()] = ReadFileBytes(entry.path());
  }
  return files;
}

void ExpectSame(const fs::path& a, const fs::path& b) {
  const auto left = BytesOf(a), right = BytesOf(b);
  ASSERT_EQ(left.size(), right.size());
  for (const auto& [name, bytes] : left) {
    ASSERT_TRUE(right.contains(name)) << name;
    EXPECT_EQ(bytes, right.at(name)) << name;
  }
}

TEST(BopMake, SameBytesForAnyJobCountAndAfterResume) {
  const TemporaryFolder folder;
  const fs::path one = folder.path() / "one", two = folder.path() / "two",
                 stopped = folder.path() / "stopped";
  EXPECT_EQ(MakeSmall(one, 3, 2, 1).done, 3);
  EXPECT_EQ(MakeSmall(two, 3, 2, 2).done, 3);
  ExpectSame(one, two);

  // The stopped run left one complete scene and one that was cut off.
  EXPECT_EQ(MakeSmall(stopped, 1, 2).done, 1);
  EXPECT_TRUE(MakeSmall(stopped, 3, 2, 1, true, [] { return true; }).stopped);
  fs::create_directories(stopped / "test" / ".000002.unfinished" / "rgb");
  WriteFileAtomically(stopped / "test" / ".000002.unfinished" / "rgb" / "000000.png", "half");
  const MakeDatasetReport resumed = MakeSmall(stopped, 3, 2, 1, true);
  EXPECT_EQ(resumed.done_before, 1);
  EXPECT_EQ(resumed.done, 3);
  EXPECT_EQ(MakeSmall(stopped, 2, 2, 1, true).done, 2) << "only requested scenes count";
  ExpectSame(one, stopped);

  EXPECT_THROW(MakeSmall(one, 3, 2), InputError) << "nothing is overwritten unless resumed";
  EXPECT_THROW(MakeSmall(one, 3, 5, 1, true), InputError) << "other settings";
  ExpectSame(one, two);
}

TEST(BopMake, AWrittenSceneWhoseWorkerWasKilledIsNotLost) {
  const std::vector<LostItem> lost =
      NotWritten({{2, "killed by signal 9"}, {3, "killed by signal 9"}}, {1, 2, 4});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost.front().item, 3);
}

Image<uint8_t> MaskIn(const fs::path& folder, const char* kind, int image, int position) {
  return ReadPng8(folder / kind / MaskFileName(image, position));
}

int Pixels(const Image<uint8_t>& mask) {
  int set = 0;
  for (const uint8_t value : mask.pixels()) set += value == 255;
  return set;
}

// Compares a scene of the dataset with the same scene built again.
class BopTruth : public ::testing::Test {
 protected:
  static constexpr int kViews = 2;
  static void SetUpTestSuite() {
    set_ = new TemporaryFolder;
    MakeSmall(set_->path(), 1, kViews);
  }
  static void TearDownTestSuite() { delete set_; }
  static fs::path folder() { return set_->path() / "test" / "000001"; }
  static SceneTruth Truth() { return ReadSceneTruth(folder(), 1, ThrowFault); }
  static Image<uint8_t> Mask(const char* kind, int image, int position) {
    return MaskIn(folder(), kind, image, position);
  }
  // Camera of an image, with its pose in the world frame.
  static Camera CameraOfImage(const ImageTruth& image) {
    const CameraSpec size = SmallScenario().camera;
    return {image.projection.ForSize(size.width, size.height), image.X_CW->inverse()};
  }

  static TemporaryFolder* set_;
};
TemporaryFolder* BopTruth::set_ = nullptr;

TEST_F(BopTruth, MasksAndDepthEqualTheRenderedScene) {
  SimulatedCell cell(SmallScenario(), EasyCube());
  SceneRenderer renderer(cell.objects(), cell.bin());
  const Scene scene = cell.MakeScene(BinIndex{0}).scene;
  ASSERT_EQ(scene.objects.size(), static_cast<size_t>(kSmallInstances));
  const SceneTruth truth = Truth();
  ASSERT_EQ(truth.images.size(), static_cast<size_t>(kViews));
  for (const auto& [id, image] : truth.images) {
    const RenderedImage rendered = renderer.Render(scene, CameraOfImage(image));
    // Each pose is X_CW * X_WO.
    for (int i = 0; i < kSmallInstances; ++i) {
      const Pose X_CO = *image.X_CW * scene.objects[i].X_WO;
      EXPECT_TRUE(image.instances[i].X_CO.isApprox(X_CO, 1e-9));
      const Image<uint8_t> visible = Mask("mask_visib", id, i), whole = Mask("mask", id, i);
      for (size_t p = 0; p < visible.size(); ++p) {
        EXPECT_EQ(visible.data()[p] == 255, rendered.ids.data()[p] == i + 1);
        EXPECT_LE(visible.data()[p], whole.data()[p]) << "visible pixels belong to the silhouette";
      }
    }
    // The sensor is ideal, so depth differs only by the rounding to units of the file.
    const Image<uint16_t> units = ReadPng16(folder() / "depth" / ImageFileName(id));
    int readings = 0;
    for (size_t p = 0; p < units.size(); ++p) {
      const double read_mm = units.data()[p] * image.depth_scale_mm;
      const double drawn_mm = 1e3 * rendered.depth_m.data()[p];
      EXPECT_NEAR(read_mm, drawn_mm, 0.5 * image.depth_scale_mm + 1e-3);
      readings += units.data()[p] > 0;
    }
    EXPECT_GT(readings, 1000);
  }
}

// A pile, in which instances hide parts of others.
TEST(BopMake, VisibleFractionIsVisiblePixelsOverAllPixels) {
  constexpr int kPile = 30;
  const TemporaryFolder set;
  MakeSmall(set.path(), 1, 1, 1, false, {}, kPile);
  const fs::path folder = set.path() / "test" / "000001";
  const SceneTruth truth = ReadSceneTruth(folder, 1, ThrowFault);
  ASSERT_EQ(truth.images.size(), 1u);
  int hidden = 0;
  for (const auto& [id, image] : truth.images) {
    const Image<uint16_t> depth = ReadPng16(folder / "depth" / ImageFileName(id));
    ASSERT_EQ(image.infos.size(), static_cast<size_t>(kPile));
    for (int i = 0; i < kPile; ++i) {
      const InstanceInfo& info = image.infos[i];
      const Image<uint8_t> mask = MaskIn(folder, "mask", id, i);
      const Image<uint8_t> visible = MaskIn(folder, "mask_visib", id, i);
      EXPECT_EQ(info.px_count_visib, Pixels(visible));
      EXPECT_GE(info.px_count_all, Pixels(mask)) << "pixels outside the image count too";
      ASSERT_GT(info.px_count_all, 0);
      EXPECT_DOUBLE_EQ(info.visib_fract,
                       static_cast<double>(info.px_count_visib) / info.px_count_all);
      int valid = 0;
      for (size_t p = 0; p < mask.size(); ++p) valid += mask.data()[p] > 0 && depth.data()[p] > 0;
      EXPECT_EQ(info.px_count_valid, valid);
      // Pixels of the silhouette outside the image are not hidden by another instance.
      hidden += Pixels(visible) < Pixels(mask);
    }
  }
  EXPECT_GT(hidden, 0) << "the pile must hide parts of some instances";
}

TEST_F(BopTruth, CocoAnnotationsDecodeToTheVisibleMasks) {
  const ParsedJson coco = ParsedJson::parse(ReadFileBytes(folder() / "scene_gt_coco.json"));
  ASSERT_EQ(coco["images"].size(), static_cast<size_t>(kViews));
  int seen = 0;
  for (const ParsedJson& annotation : coco["annotations"]) {
    const int image = annotation["image_id"], number = annotation["id"];
    const Image<uint8_t> mask = Mask("mask_visib", image, (number - 1) % kSmallInstances);
    // COCO run lengths go down the columns and begin with unset pixels.
    size_t at = 0;
    bool set = false;
    for (const int run : annotation["segmentation"]["counts"]) {
      for (int k = 0; k < run; ++k, ++at) {
        const int x = static_cast<int>(at) / mask.height(),
                  y = static_cast<int>(at) % mask.height();
        ASSERT_EQ(mask(x, y) == 255, set);
      }
      set = !set;
    }
    EXPECT_EQ(at, mask.size());
    EXPECT_EQ(annotation["area"], Pixels(mask));
    ++seen;
  }
  EXPECT_GT(seen, 0);
}

TEST(BopRunLengths, EqualHandComputedRuns) {
  Image<uint8_t> mask(3, 2);
  EXPECT_EQ(RunLengths(mask), (std::vector<int>{6}));
  mask(0, 1) = mask(1, 0) = mask(2, 1) = 255;  // columns: 0 1 | 1 0 | 0 1
  EXPECT_EQ(RunLengths(mask), (std::vector<int>{1, 2, 2, 1}));
  mask(0, 0) = 255;  // the first pixel is set: the first run is empty
  EXPECT_EQ(RunLengths(mask), (std::vector<int>{0, 3, 2, 1}));
}

std::vector<DatasetEstimate> TruthAsEstimates(const SceneTruth& scene) {
  std::vector<DatasetEstimate> estimates;
  for (const auto& [id, image] : scene.images) {
    for (const DatasetInstance& instance : image.instances) {
      estimates.push_back({scene.scene_id, id, instance.object_id, 1.0, instance.X_CO, 0.1});
    }
  }
  return estimates;
}

TEST_F(BopTruth, GroundTruthAsEstimateScoresOne) {
  const DatasetScores scores = EvaluateDataset(set_->path(), "test", TruthAsEstimates(Truth()));
  EXPECT_EQ(scores.images, kViews);
  EXPECT_GT(scores.wanted, 0);
  EXPECT_DOUBLE_EQ(scores.ar_vsd, 1);
  EXPECT_DOUBLE_EQ(scores.ar_mssd, 1);
  EXPECT_DOUBLE_EQ(scores.ar_mspd, 1);
  EXPECT_DOUBLE_EQ(scores.adi_recall, 1);
  EXPECT_DOUBLE_EQ(scores.ap(), 1);
  EXPECT_DOUBLE_EQ(scores.seconds_an_image, 0.1);
}

// Each vertex of the cube stays the nearest one to itself while it moves by less than half the
// cube's side.
TEST_F(BopTruth, AdiRecallAcceptsATenthOfTheDiameter) {
  const double diameter_m = EasyCube().front()->diameter_m;
  const auto recall_at = [&](double shift_diameters) {
    std::vector<DatasetEstimate> estimates = TruthAsEstimates(Truth());
    for (DatasetEstimate& estimate : estimates) {
      estimate.X_CO.pretranslate(Eigen::Vector3d(shift_diameters * diameter_m, 0, 0));
    }
    return EvaluateDataset(set_->path(), "test", estimates).adi_recall;
  };
  EXPECT_EQ(recall_at(0.095), 1);
  EXPECT_EQ(recall_at(0.105), 0);
}

// The poses of the two images are exchanged. Their cameras differ by tens of degrees and
// centimetres.
TEST_F(BopTruth, ExchangedGroundTruthScoresNearZero) {
  std::vector<DatasetEstimate> estimates = TruthAsEstimates(Truth());
  for (DatasetEstimate& estimate : estimates) estimate.image_id = 1 - estimate.image_id;
  const DatasetScores scores = EvaluateDataset(set_->path(), "test", estimates);
  EXPECT_LT(scores.ar(), 0.1);
  EXPECT_LT(scores.adi_recall, 0.1);
  EXPECT_LT(scores.ap(), 0.1);
}

// Ground truth as estimate gives the pick chance of a zero error. An instance without an estimate
// counts as 0.
TEST_F(BopTruth, PickChanceFollowsFromThePoseErrors) {
  ToleranceModel model = EmptyToleranceModel(*EasyCube().front(), "jaw", {Pose::Identity()});
  model.weights[0] = 0.5;   // logistic(0.5) for a zero error
  model.weights[2] = -100;  // lower for an error along x
  const TolerancesById tolerances{{1, {"model.yaml", model}}};
  const auto chance_of = [&](const std::vector<DatasetEstimate>& estimates) {
    return EvaluateDataset(set_->path(), "test", estimates, {}, tolerances)
        .objects.at(1)
        .pick_chance;
  };
  std::vector<DatasetEstimate> estimates = TruthAsEstimates(Truth());
  EXPECT_NEAR(chance_of(estimates).value(), 1 / (1 + std::exp(-0.5)), 1e-6);
  EXPECT_FALSE(
      EvaluateDataset(set_->path(), "test", estimates).objects.at(1).pick_chance.has_value());
  estimates.resize(estimates.size() / 2);
  EXPECT_LT(chance_of(estimates).value(), 0.6) << "an instance that is not found counts as 0";
  EXPECT_EQ(chance_of({}).value(), 0);
  const TolerancesById unknown_object{{7, {"model.yaml", model}}};
  EXPECT_THROW(EvaluateDataset(set_->path(), "test", estimates, {}, unknown_object), InputError);
  const ObjectModel other = *Cube(0.06, 0.1, 0.5);
  const TolerancesById other_mesh{
      {1, {"model.yaml", EmptyToleranceModel(other, "jaw", {Pose::Identity()})}}};
  EXPECT_THROW(EvaluateDataset(set_->path(), "test", estimates, {}, other_mesh), InputError);
}

TEST(DatasetCard, DamagedHashesAndSettingsAreNamed) {
  const TemporaryFolder folder;
  MakeSmall(folder.path(), 1, 1);
  const std::string card = ReadFileBytes(folder.path() / kCardFile);
  EXPECT_EQ(ObjectsOfCard(folder.path()).at(1).mesh_hash, EasyCube()[0]->mesh_hash);
  const auto error = [&](const std::string& before, const std::string& damaged) {
    const size_t at = card.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    std::string text = card;
    folder.Write(kCardFile, text.replace(at + before.size(), damaged.size(), damaged));
    return ErrorOf([&] { ObjectsOfCard(folder.path()); });
  };
  EXPECT_THAT(error("\"mesh\": \"", "+"), HasSubstr("is no hash"));
  EXPECT_THAT(error("\"000001\": \"", "="), HasSubstr("is no hash"));
  EXPECT_THAT(error("trials: ", "7"), HasSubstr("its settings differ from dataset_settings.yaml"));
  EXPECT_THAT(error("\"sett", "I"), HasSubstr("key 'settings' not found"));
  EXPECT_THAT(error("\"hash\": \"", "="), HasSubstr("is no hash"));
  // The settings are of another split, whose card is written after its last scene.
  folder.Write(kCardFile, card);
  std::string settings = ReadFileBytes(folder.path() / kDatasetSettingsFile);
  folder.Write(kDatasetSettingsFile, settings.replace(settings.find("seed:"), 6, "seed: 1"));
  EXPECT_THAT(ErrorOf([&] { ObjectsOfCard(folder.path()); }), HasSubstr("its settings differ"));
  settings.insert(settings.size() - 1, "_2");
  folder.Write(kDatasetSettingsFile, settings);
  EXPECT_EQ(ObjectsOfCard(folder.path()).size(), 1u);
}

TEST(ReadTolerances, MalformedArgumentsAreRefused) {
  EXPECT_THROW(ReadTolerances({"flange"}), InputError);
  EXPECT_THROW(ReadTolerances({"=flange"}), InputError);
  EXPECT_THROW(ReadTolerances({"1=/no/such/place"}), InputError);
}

}  // namespace
}  // namespace pickbed::tests
