// Compares the BOP scores with reference_scores.py, which computes them anew in numpy from the
// published definitions.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/bop/dataset_scores.h"
#include "eval/bop/layout.h"
#include "eval/bop/score_accumulator.h"
#include "eval/runtime/process.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"
#include "tests/eval/bop_small_dataset.h"
#include "tests/support/plugin_scripts.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

constexpr double kSame = 1e-4;

// Several estimates per instance, with errors from none to far off, and false ones.
std::vector<DatasetEstimate> NoisyEstimates(const fs::path& root, int of_each, double noise_m) {
  std::vector<DatasetEstimate> estimates;
  Rng rng(17);
  for (const int scene_id : SceneIdsOf(root, "test")) {
    const SceneTruth scene =
        ReadSceneTruth(root / "test" / SceneFolderName(scene_id), scene_id, ThrowFault);
    for (const auto& [image_id, image] : scene.images) {
      for (const DatasetInstance& instance : image.instances) {
        for (int i = 0; i < of_each; ++i) {
          DatasetEstimate& estimate = estimates.emplace_back();
          estimate.scene_id = scene_id;
          estimate.image_id = image_id;
          estimate.object_id = instance.object_id;
          estimate.score = rng.Uniform(0, 1);
          const double size = rng.Uniform(0, 1);
          estimate.X_CO = instance.X_CO;
          const Eigen::Vector3d shift_C = size * noise_m * rng.UnitVector();
          estimate.X_CO.pretranslate(shift_C);
          estimate.X_CO.rotate(Eigen::AngleAxisd(0.5 * size, rng.UnitVector()));
        }
      }
    }
  }
  return estimates;
}

nlohmann::json Reference(const fs::path& root, const fs::path& csv, bool with_vsd = true) {
  std::vector<std::string> command{
      kPython, std::string(PICKBED_SOURCE_DIR) + "/tests/eval/bop/reference_scores.py",
      root.string(), "test", csv.string()};
  if (!with_vsd) command.push_back("--no-vsd");
  const ProgramOutput output = RunProgram(command);
  EXPECT_EQ(output.status, 0) << output.text;
  return output.status == 0 ? nlohmann::json::parse(output.text) : nlohmann::json();
}

void ExpectSame(const DatasetScores& scores, const nlohmann::json& reference, bool with_vsd) {
  const auto same = [&](double value, const char* key) {
    EXPECT_NEAR(value, reference.at(key).get<double>(), kSame) << key;
  };
  if (with_vsd) {
    same(scores.ar_vsd, "bop19_average_recall_vsd");
    same(scores.ar(), "bop19_average_recall");
  }
  same(scores.ar_mssd, "bop19_average_recall_mssd");
  same(scores.ar_mspd, "bop19_average_recall_mspd");
  same(scores.ap_mssd, "bop24_mAP_mssd");
  same(scores.ap_mspd, "bop24_mAP_mspd");
  same(scores.ap(), "bop24_mAP");
  same(scores.ap_mssd, "bop25_mAP");
  same(scores.ap_mssd_mm, "bop25_mAP_mm");
}

TEST(BopScoreReference, ExportedDatasetScoresAsInNumpy) {
  const TemporaryFolder folder;
  MakeSmall(folder.path(), 3, 2);
  const std::vector<DatasetEstimate> estimates = NoisyEstimates(folder.path(), 3, 0.03);
  const fs::path csv = folder.Write("noisy.csv", WriteEstimates(estimates));
  const DatasetScores scores = EvaluateDataset(folder.path(), "test", ReadEstimates(csv));
  EXPECT_GT(scores.ar_vsd, 0.05);
  EXPECT_LT(scores.ar_vsd, 0.95);
  EXPECT_GT(scores.ap_mssd_mm, 0.05);
  ExpectSame(scores, Reference(folder.path(), csv), true);
}

// A frame of a real sensor with meshes of five objects. (Its meshes are too large to draw in
// numpy.)
TEST(BopScoreReference, RealDatasetScoresAsInNumpy) {
  const fs::path root = fs::path(PICKBED_TEST_DATA) / "bop_ycbv_mini";
  if (!fs::exists(root)) GTEST_SKIP() << "needs " << root;
  const TemporaryFolder folder;
  const fs::path csv = folder.Write("noisy.csv", WriteEstimates(NoisyEstimates(root, 3, 0.03)));
  const DatasetScores scores = EvaluateDataset(root, "test", ReadEstimates(csv));
  EXPECT_GT(scores.ap_mssd, 0.05);
  ExpectSame(scores, Reference(root, csv, /*with_vsd=*/false), false);
}

// Estimates of one object: right, right, near, far, in falling order of the score. The last
// instance is hidden.
TEST(BopDetectionCounts, NeverReportedAndFloorsEqualHandCounts) {
  const double diameter_m = EasyCube().front()->diameter_m;
  const CameraIntrinsics camera{64, 48, 100, 100, 32, 24};
  const Image<float> depth_m(64, 48, 0.0f);
  ScoredImage image{camera, depth_m, {}};
  for (const double visible : {1.0, 0.6, 0.4, 0.05}) {
    const double x_m = 0.2 * static_cast<double>(image.instances.size());
    image.instances.push_back({1, MakePose(Eigen::Matrix3d::Identity(), {x_m, 0, 1}), visible});
  }
  std::vector<DatasetEstimate> estimates;
  for (const double offset : {0.0, 0.08, 0.3}) {
    DatasetEstimate estimate{1, 0, 1, 1.0 - 0.1 * static_cast<double>(estimates.size())};
    estimate.X_CO = image.instances[estimates.size()].X_CO;
    estimate.X_CO.pretranslate(Eigen::Vector3d(0, offset * diameter_m, 0));
    estimates.push_back(estimate);
  }
  estimates[2].X_CO.pretranslate(Eigen::Vector3d(0, diameter_m, 0));
  std::vector<const DatasetEstimate*> all;
  for (const DatasetEstimate& estimate : estimates) all.push_back(&estimate);
  const auto score = [&](int max_estimates) {
    ScoreAccumulator accumulator([](int) { return EasyCube().front(); }, {}, {}, max_estimates);
    ImageTargets targets;
    targets.detected = true;
    accumulator.AddImage(image, targets, all);
    DatasetScores scores;
    accumulator.Finish(scores);
    return scores;
  };
  const DatasetScores scores = score(100);
  EXPECT_EQ(scores.detect_wanted, 3);
  EXPECT_EQ(scores.never_reported, 1);
  ASSERT_EQ(scores.floors.size(), 5u);
  EXPECT_EQ(scores.floors[0].instances, 3);
  EXPECT_EQ(scores.floors[0].correct, 2);
  EXPECT_NEAR(scores.floors[0].average_recall, (1 + 0.9) / 3, 1e-12)
      << "the second one is right from 0.1 diameters on";
  EXPECT_EQ(scores.floors[2].instances, 2);
  EXPECT_EQ(scores.floors[3].instances, 1);
  EXPECT_NEAR(scores.floors[3].average_recall, 1, 1e-12);
  EXPECT_LT(score(1).ap_mssd, scores.ap_mssd) << "one estimate of the image counts";
}

TEST(MaxEstimatesOf, IsAsInTheToolkit) {
  EXPECT_EQ(MaxEstimatesOf("/data/bop/xyzibd"), 200);
  EXPECT_EQ(MaxEstimatesOf("/data/bop/xyzibd/"), 200);
  EXPECT_EQ(MaxEstimatesOf("/data/bop/ycbv"), 100);
}

}  // namespace
}  // namespace pickbed::tests
