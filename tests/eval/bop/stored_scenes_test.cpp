#include "eval/bop/stored_scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/bop/layout.h"
#include "eval/cell/simulated_cell.h"
#include "eval/trial/stage_hash.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/scenario/scenario_text.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// A settled scene and one after a pick.
class StoredScenesTest : public testing::Test {
 protected:
  StoredScenesTest() {
    const ScenarioSpec spec = SmallScenario();
    SimulatedCell cell(spec, EasyCube());
    full_ = cell.MakeScene(BinIndex(2)).scene;
    full_.objects[1].deviation = {0.25, -1.0 / 3};
    picked_ = full_;
    picked_.objects.erase(picked_.objects.begin());
    stored_ = {spec.seed, BinIndex(2), {0.01}, {}};
    stored_.Add(0, full_);
    stored_.Add(1, full_);
    stored_.Add(4, picked_);
  }
  StoredScenes Read(const std::string& text, const ObjectSet& objects = EasyCube()) {
    folder_.Write(kStoredScenesFile, text);
    return ReadStoredScenes(folder_.path(), full_.bin, objects);
  }
  std::string ErrorOfText(const std::string& text, const ObjectSet& objects = EasyCube()) {
    return ErrorOf([&] { Read(text, objects); });
  }
  // The text with its first `was` replaced.
  std::string Changed(const std::string& was, const std::string& is) {
    std::string text = StoredScenesText(stored_, EasyCube());
    const size_t place = text.find(was);
    EXPECT_NE(place, std::string::npos) << was;
    return text.replace(place, was.size(), is);
  }

  TemporaryFolder folder_;
  Scene full_, picked_;
  StoredScenes stored_;
};

TEST_F(StoredScenesTest, EveryBitOfAScenePassesThroughTheFile) {
  const StoredScenes read = Read(StoredScenesText(stored_, EasyCube()));
  EXPECT_EQ(read.seed, stored_.seed);
  EXPECT_EQ(int{read.bin_index}, 2);
  EXPECT_EQ(read.sizes, stored_.sizes);
  EXPECT_EQ(read.scenes.size(), 2u) << "equal scenes are stored once";
  EXPECT_EQ(HashOf(read.Of(0, folder_.path())), HashOf(full_));
  EXPECT_EQ(HashOf(read.Of(1, folder_.path())), HashOf(full_));
  EXPECT_EQ(HashOf(read.Of(4, folder_.path())), HashOf(picked_));
  EXPECT_EQ(read.Of(0, "").objects[1].deviation, full_.objects[1].deviation);
  EXPECT_EQ(StoredScenesText(read, EasyCube()), StoredScenesText(stored_, EasyCube()));
}

TEST_F(StoredScenesTest, FaultsAreNamedInOneLine) {
  EXPECT_THAT(ErrorOf([&] { ReadStoredScenes(folder_.path() / "none", full_.bin, EasyCube()); }),
              HasSubstr("stored_scenes.json: is missing"));
  EXPECT_THAT(ErrorOfText("{"), HasSubstr(kStoredScenesFile));
  EXPECT_THAT(ErrorOfText("{}"), HasSubstr("was not written by pickbed"));
  EXPECT_THAT(ErrorOfText(Changed("\"format\": 1", "\"format\": 9")), HasSubstr("has format 9"));
  EXPECT_THAT(ErrorOfText(Changed("\"obj_id\":1", "\"obj_id\":7")), HasSubstr("object cube"));
  EXPECT_THAT(ErrorOfText(Changed("\"size_deviation\"", "\"size\"")), HasSubstr("is damaged"));
  for (const char* key : {"friction_deviation", "mass_deviation"}) {
    StoredScenes absurd = stored_;
    InstanceDeviation& deviation = absurd.scenes.front().objects.front().deviation;
    (key[0] == 'f' ? deviation.friction : deviation.mass) = 2147483648.0;
    EXPECT_THAT(ErrorOfText(StoredScenesText(absurd, EasyCube())),
                HasSubstr("an instance deviates by 2.14748e+09 times"));
  }
  StoredScenes far = stored_;
  far.scenes.front().objects.front().X_WO.translation().x() = 1e6;
  EXPECT_THAT(ErrorOfText(StoredScenesText(far, EasyCube())), HasSubstr("is 1e+06 m from the bin"));
  StoredScenes twice = stored_;
  twice.scenes.front().objects[1].instance = twice.scenes.front().objects[0].instance;
  EXPECT_THAT(ErrorOfText(StoredScenesText(twice, EasyCube())), HasSubstr("a scene has instance"));
  StoredScenes stretched = stored_;
  stretched.scenes.front().objects.front().X_WO.linear() *= 2;
  EXPECT_THAT(ErrorOfText(StoredScenesText(stretched, EasyCube())),
              HasSubstr("'R': is no rotation"));
  stretched.scenes.front().objects.front().X_WO.linear() *= 0.5005;
  EXPECT_THAT(ErrorOfText(StoredScenesText(stretched, EasyCube())),
              HasSubstr("'R': is no rotation, but was written with all digits"));
  EXPECT_THAT(ErrorOfText(StoredScenesText(stored_, EasyCube()), {Cube(0.03, 0.06, 0.6)}),
              HasSubstr("object cube differs now"))
      << "another mass";
  EXPECT_THAT(ErrorOfText(StoredScenesText(stored_, EasyCube()), {Cube(0.031, 0.05, 0.6)}),
              HasSubstr("object cube differs now"))
      << "another mesh";
  full_.bin.wall_m *= 2;
  EXPECT_THAT(ErrorOfText(StoredScenesText(stored_, EasyCube())), HasSubstr("another bin"));
  EXPECT_THAT(ErrorOf([&] { stored_.Of(3, "place"); }), HasSubstr("no scene of image 3"));
}

TEST_F(StoredScenesTest, ADatasetHasTheSceneThatItsImagesShow) {
  const TemporaryFolder out;
  MakeSmall(out.path(), 2, 2);
  const ScenarioSpec spec = ScenarioOfText(ReadFileBytes(out.path() / kDatasetScenarioFile),
                                           out.path(), kDatasetScenarioFile);
  EXPECT_EQ(spec.seed, SmallScenario().seed);
  SimulatedCell cell(SmallScenario(), EasyCube());
  for (const int id : {1, 2}) {
    const std::filesystem::path folder = out.path() / "test" / SceneFolderName(id);
    const StoredScenes read = ReadStoredScenes(folder, cell.bin(), EasyCube());
    const uint64_t made = HashOf(cell.MakeScene(BinIndex(id - 1)).scene);
    for (const int view : {0, 1}) EXPECT_EQ(HashOf(read.Of(view, folder)), made);
  }
}

}  // namespace
}  // namespace pickbed::tests
