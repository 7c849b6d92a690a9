#include "eval/sweep/run_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "eval/bop/check_dataset.h"
#include "eval/bop/layout.h"
#include "eval/sweep/run.h"
#include "eval/trial/stage_hash.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

// A run that writes its images.
class RunImagesTest : public testing::Test {
 protected:
  RunReport Run(const std::string& name, int trials, int jobs = 1, bool resume = false,
                bool with_images = true, const std::string& data = "") {
    ScenarioSpec spec = SmallScenario();
    spec.trials = trials;
    spec.estimator.noise_mm = 3;  // so that some picks fail and move neighbors
    RunOptions options;
    options.out = folder_.path() / (name + "_run");
    options.jobs = jobs;
    options.resume = resume;
    options.picture_trials = options.failure_picture_trials = 0;
    if (with_images) options.bop_out = Data(data.empty() ? name : data);
    return RunScenario(spec, EasyCube(), options, {});
  }
  fs::path Data(const std::string& name) const { return folder_.path() / name; }
  // Bytes of every file of a data set, by relative path.
  std::map<std::string, std::string> BytesOf(const std::string& name) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(Data(name))) {
      if (!entry.is_regular_file()) continue;
      files[entry.path().lexically_relative(Data(name)).string()] = ReadFileBytes(entry.path());
    }
    return files;
  }

  TemporaryFolder folder_;
};

TEST_F(RunImagesTest, EveryImageOfTheRunIsInTheDataset) {
  const RunReport report = Run("set", 2);
  EXPECT_THAT(CheckDataset(Data("set")).faults, IsEmpty());
  SimulatedCell cell(SmallScenario(), EasyCube());
  size_t shrunk = 0;
  for (const TrialResult& trial : report.trials) {
    const fs::path folder = Data("set") / kRunSplit / SceneFolderName(trial.trial + 1);
    const SceneTruth truth = ReadSceneTruth(folder, trial.trial + 1, ThrowFault);
    const StoredScenes stored = ReadStoredScenes(folder, cell.bin(), EasyCube());
    ASSERT_EQ(truth.images.size(), trial.attempts.size());
    for (const AttemptRecord& attempt : trial.attempts) {
      const Scene& scene = stored.Of(attempt.attempt, folder);
      EXPECT_EQ(HashOf(scene), attempt.hashes[TrialStage::kScene]);
      const ImageTruth& image = truth.images.at(attempt.attempt);
      ASSERT_EQ(image.instances.size(), scene.objects.size());
      shrunk += scene.objects.size() < static_cast<size_t>(kSmallInstances);
      for (size_t i = 0; i < scene.objects.size(); ++i) {
        EXPECT_NEAR(image.infos[i].visib_fract, attempt.instances[i].visible_fraction, 1e-12);
        EXPECT_TRUE(image.instances[i].X_CO.isApprox(*image.X_CW * scene.objects[i].X_WO, 1e-9));
      }
    }
  }
  EXPECT_GT(shrunk, 0u) << "the case did not occur";
}

TEST_F(RunImagesTest, SameBytesForAnyNumberOfJobsAndAfterAStop) {
  Run("one", 3, 1);
  Run("two", 3, 2);
  const auto one = BytesOf("one");
  EXPECT_EQ(BytesOf("two"), one);
  EXPECT_FALSE(fs::exists(Data("one") / kRunSplit / ".000001.unfinished"));

  Run("stopped", 1, 1);
  fs::create_directories(Data("stopped") / kRunSplit / ".000002.unfinished" / "rgb");
  Run("stopped", 3, 1, /*resume=*/true);
  EXPECT_EQ(BytesOf("stopped"), one);
}

TEST_F(RunImagesTest, ImagesDoNotChangeTheRun) {
  Run("with", 2);
  Run("without", 2, 1, false, /*with_images=*/false);
  EXPECT_EQ(ReadFileBytes(folder_.path() / "with_run" / kAttemptsFile),
            ReadFileBytes(folder_.path() / "without_run" / kAttemptsFile));
  EXPECT_FALSE(fs::exists(Data("without")));
}

TEST_F(RunImagesTest, FoldersThatDoNotFitAreRefused) {
  Run("set", 1);
  fs::remove_all(folder_.path() / "set_run");
  EXPECT_THAT(ErrorOf([&] { Run("set", 1); }), HasSubstr("already has 1 scenes"));
  EXPECT_THAT(ErrorOf([&] { Run("set", 1, 1, /*resume=*/true); }),
              HasSubstr("the run has no finished trial"));
  EXPECT_TRUE(fs::exists(Data("set") / kRunSplit / SceneFolderName(1))) << "nothing is removed";
  Run("plain", 1, 1, false, /*with_images=*/false);
  EXPECT_THAT(ErrorOf([&] { Run("plain", 2, 1, /*resume=*/true); }),
              HasSubstr("no images of the finished trial 0"));
}

// The scenes of an equal run have the same settings, so only the trials show whose they are.
TEST_F(RunImagesTest, ScenesOfAnEqualRunAreNotRemoved) {
  Run("whole", 3);
  const auto whole = BytesOf("whole");
  Run("short", 1, 1, false, /*with_images=*/false);
  EXPECT_THAT(ErrorOf([&] { Run("short", 2, 1, /*resume=*/true, true, "whole"); }),
              HasSubstr("has a scene of trial 1, which"));
  EXPECT_EQ(BytesOf("whole"), whole);
  // A scene that a killed process wrote before its trial was stored is of the own results.
  Run("killed", 1);
  fs::copy(Data("whole") / kRunSplit / SceneFolderName(2),
           Data("killed") / kRunSplit / SceneFolderName(2), fs::copy_options::recursive);
  Run("killed", 3, 1, /*resume=*/true);
  EXPECT_EQ(BytesOf("killed"), whole);
}

TEST_F(RunImagesTest, AFolderThatCannotBeMadeNamesItself) {
  folder_.Write("file", "");
  EXPECT_THAT(ErrorOf([&] { Run("mine", 1, 1, false, true, "file/set"); }),
              HasSubstr("choose another image folder"));
}

}  // namespace
}  // namespace pickbed::tests
