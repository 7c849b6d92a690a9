#include "scenes/scenario/scenario_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/scenario/load_objects.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

class ScenarioFile : public ::testing::Test {
 protected:
  std::string ErrorOf(const std::string& yaml, const std::vector<std::string>& overrides = {}) {
    const std::filesystem::path file = folder_.Write("scenario.yaml", yaml);
    try {
      LoadScenario(file, overrides);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  const TemporaryFolder folder_;
};

TEST_F(ScenarioFile, PresetsLoadAndReadBackUnchanged) {
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(PICKBED_SOURCE_DIR) + "/scenes/presets")) {
    if (entry.is_directory()) continue;
    ScenarioSpec spec = LoadScenario(entry.path());
    const std::string text = WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); });
    ScenarioSpec copy;
    ReadSettingsText(text, "copy", [&](SettingsVisitor& v) { copy.Visit(v); });
    EXPECT_EQ(WriteSettings([&](SettingsVisitor& v) { copy.Visit(v); }), text) << entry.path();
  }
}

// Industrial cameras look at such bins from 1 to 1.3 m. The presets say where the pile begins.
TEST_F(ScenarioFile, DeepPresetsAreFilledBinsSeenFromAnIndustrialDistance) {
  int presets = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(PICKBED_SOURCE_DIR) + "/scenes/presets")) {
    const std::string name = entry.path().stem();
    if (!name.starts_with("deep_")) continue;
    const ScenarioSpec spec = LoadScenario(entry.path());
    if (spec.fill == 0) continue;  // deep_huge and deep_unknown give counts
    ++presets;
    EXPECT_EQ(spec.arrangement, "pile") << name;
    EXPECT_NEAR(spec.fill, 0.66, 1e-9) << name;
    EXPECT_EQ(spec.camera.width, 1224) << name;
    EXPECT_EQ(spec.camera.height, 1024) << name;
    const double fill_height_m = spec.fill * spec.bin.inner_size_m.z();
    const double distance_m = (CameraOf(spec).X_CW() * Eigen::Vector3d(0, 0, fill_height_m)).z();
    EXPECT_GT(distance_m, 0.95) << name;
    EXPECT_LT(distance_m, 1.4) << name;
  }
  EXPECT_EQ(presets, 13) << "twelve parts and a mixed bin";
}

TEST_F(ScenarioFile, FormerNameOfARefinerIsRead) {
  const std::filesystem::path file =
      folder_.Write("scenario.yaml", "objects: [{name: rod, count: 2}]\nrefiner: two_way_icp\n");
  EXPECT_EQ(LoadScenario(file).refiner, "bidirectional_icp");
}

TEST_F(ScenarioFile, InvalidScenariosAreRefusedInOneLine) {
  const std::string rods = "objects: [{name: rod, count: 2}]\n";
  const struct {
    std::string yaml;
    const char* fragment;
  } cases[] = {
      {"", "has no settings"},
      {"trials: 1\n", "drops nothing"},
      {"objects: []\n", "drops nothing"},
      {"objects: [{name: rod, count: 0}]\n", "objects.0.count = 0"},
      {"objects: [{name: rod, count: -3}]\n", "objects.0.count = -3"},
      {"objects: [{count: 3}]\n", "objects.0.name"},
      {"objects: [{name: rod}, {name: rod}]\n", "twice"},
      {"objects: [{name: x, mesh: a.obj}]\n", "give mass_kg, the mass of 'x' in kg"},
      {rods + "camera: {eye_m: [0.202, 0, 0.05]}\n", "inside the bin"},
      {rods + "camera: {eye_m: [0.1, 0, 0.1]}\n", "inside the bin"},
      {rods + "camera: {eye_m: [0, 0, -0.5]}\n", "under the bin's floor"},
      {rods + "camera: {eye_m: [0, 0, 0.8], target_m: [0, 0, 2]}\n", "looks away"},
      {rods + "camera: {eye_m: [0, 0, 0.8], target_m: [3, 0, 0.8]}\n", "looks away"},
      {rods + "camera: {eye_m: [0, 0, 0.8], target_m: [0, 0, 0.8]}\n", "equals camera.eye_m"},
      {rods + "trials: 0\n", "trials = 0"},
  };
  for (const auto& c : cases) {
    const std::string error = ErrorOf(c.yaml);
    EXPECT_THAT(error, HasSubstr(c.fragment)) << c.yaml;
    EXPECT_THAT(error, HasSubstr("/scenario.yaml:"));
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
  EXPECT_EQ(ErrorOf(rods), "no error");
}

TEST_F(ScenarioFile, LaterErrorsHoldTheLineOfTheKey) {
  const std::filesystem::path file =
      folder_.Write("places.yaml", "seed: 1\nobjects:\n  - name: rod\n  - name: spoon\n");
  const ScenarioSpec spec = LoadScenario(file, {"gripper=tongs"});
  EXPECT_EQ(spec.At("objects.1.name"), file.string() + ":4: objects.1.name");
  EXPECT_EQ(spec.At("gripper"), "setting gripper=tongs: gripper");
  EXPECT_EQ(spec.At("sensor"), "sensor");
  try {
    LoadObjects(spec, ObjectCatalog({AssetsDir() / "objects"}));
    ADD_FAILURE() << "an unknown object was loaded";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + ":4: objects.1.name: unknown object"));
  }
}

// Bricks of 48 cm3 in a bin of 18 l: with a heap above the rim the volume is 24.75 l, of which 80 %
// can be filled. At most 412 bricks fit.
TEST_F(ScenarioFile, MoreInstancesThanTheBinHoldsAreRefused) {
  folder_.Write("brick.obj",
                "v 0 0 0\nv 60 0 0\nv 0 40 0\nv 60 40 0\nv 0 0 20\nv 60 0 20\nv 0 40 20\n"
                "v 60 40 20\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
  const std::filesystem::path file =
      folder_.Write("bricks.yaml",
                    "bin: {inner_size_m: [0.4, 0.3, 0.15]}\nobjects:\n"
                    "  - {name: rod, count: 1}\n"
                    "  - {name: brick, mesh: brick.obj, unit: mm, mass_kg: 0.1, count: 450}\n");
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  EXPECT_EQ(LoadObjects(LoadScenario(file, {"objects.1.count=405"}), catalog).size(), 2u);
  try {
    LoadObjects(LoadScenario(file), catalog);
    ADD_FAILURE() << "21.6 l of bricks were accepted for an 18 l bin";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(file.string() + ":4: objects.1.count = 450"));
    EXPECT_THAT(error.what(), HasSubstr("19.8 l at most"));
  }
}

TEST_F(ScenarioFile, OverridesApplyAfterTheFile) {
  EXPECT_THAT(ErrorOf("objects: [{name: rod}]\n", {"objects.0.count=0"}),
              HasSubstr("setting objects.0.count=0"));
}

TEST(CameraOf, PointsAtItsTargetWithAnUprightImage) {
  ScenarioSpec spec;
  for (const Eigen::Vector3d& eye : {Eigen::Vector3d(0, -0.12, 0.85), Eigen::Vector3d(0, 0, 0.9)}) {
    spec.camera.eye_m = eye;
    spec.camera.target_m = {0, 0, 0};
    const Camera camera = CameraOf(spec);
    const Eigen::Vector3d target_C = camera.X_CW() * spec.camera.target_m;
    EXPECT_NEAR(target_C.head<2>().norm(), 0, 1e-12);
    EXPECT_GT(target_C.z(), 0);
    // The bin's far side (+y) is in the upper half of the image.
    const Eigen::Vector2d far_px =
        Project(camera.intrinsics, camera.X_CW() * Eigen::Vector3d(0, 0.1, 0));
    EXPECT_LT(far_px.y(), camera.intrinsics.cy());
    EXPECT_NEAR(far_px.x(), camera.intrinsics.cx(), 1e-9);
  }
}

TEST(CameraOf, IntrinsicsAreGivenOrDefault) {
  ScenarioSpec spec;
  const CameraIntrinsics default_values = CameraOf(spec).intrinsics;
  EXPECT_EQ(default_values.fy(), default_values.fx());
  EXPECT_EQ(default_values.cx(), 319.5);
  EXPECT_EQ(default_values.cy(), 239.5);
  spec.camera.focal_px = 570;
  spec.camera.focal_y_px = 571;
  spec.camera.principal_px = {0, 242};
  const CameraIntrinsics given = CameraOf(spec).intrinsics;
  EXPECT_EQ(given.fx(), 570);
  EXPECT_EQ(given.fy(), 571);
  EXPECT_EQ(given.cx(), 0);
  EXPECT_EQ(given.cy(), 242);
}

TEST(LoadScenario, NamedBinIsLoadedAndGivenKeysOverrideIt) {
  const TemporaryFolder folder;
  const auto file = folder.Write("crate.yaml",
                                 "bin: {name: crate_600x400, wall_m: 0.02}\n"
                                 "objects: [{name: rod, count: 2}]\n");
  const ScenarioSpec spec = LoadScenario(file);
  EXPECT_EQ(spec.bin.inner_size_m, Eigen::Vector3d(0.6, 0.4, 0.2));
  EXPECT_EQ(spec.bin.wall_m, 0.02);
  const ScenarioSpec other = LoadScenario(file, {"bin.name=box_300x220", "bin.friction=0.1"});
  EXPECT_EQ(other.bin.inner_size_m.x(), 0.3);
  EXPECT_EQ(other.bin.wall_m, 0.004)
      << "the override of wall_m applies only to the bin in the file";
  EXPECT_EQ(other.bin.friction, 0.1);
  try {
    LoadScenario(file, {"bin.name=crate"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("bin.name: unknown bin 'crate'"));
  }
}

TEST(LoadObjects, RefusesAnObjectLargerThanTheBin) {
  ScenarioSpec spec;
  const TemporaryFolder folder;
  const auto file = folder.Write("huge.obj",
                                 "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                 "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  ObjectSpec object;
  object.name = "huge";
  object.mesh = file.string();
  object.mass_kg = 1;
  spec.objects = {object};
  const ObjectCatalog catalog({});
  try {
    LoadObjects(spec, catalog);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'huge' of 1000 x 1000 x 1000 mm is larger than the bin"));
  }
  spec.objects[0].unit = "cm";
  EXPECT_EQ(LoadObjects(spec, catalog).size(), 1u);
}

}  // namespace
}  // namespace pickbed::tests
