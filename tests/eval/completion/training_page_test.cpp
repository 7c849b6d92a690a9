#include "eval/completion/training_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "eval/completion/draw.h"
#include "eval/completion/sensors.h"
#include "perception/completion/training_sample.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {
namespace {

RandomView ViewOfCarton(const ViewedSolid& solid, const std::vector<DepthSensor>& sensors) {
  Rng rng(5);
  RandomViewOptions options;
  options.occluded_share = 0;
  return DrawView(solid, sensors, options, rng);
}

std::unique_ptr<ViewedSolid> Carton() {
  return SolidOf(SampleShape(FindShapeFamily("carton"), ShapeSplit::kSeen, 1).solid);
}

TEST(DepthSensorsNamed, ChangeReadingsAndRefuseUnknownNames) {
  const auto solid = Carton();
  const RandomView ideal = ViewOfCarton(*solid, DepthSensorsNamed({"ideal"}));
  const RandomView noisy = ViewOfCarton(*solid, DepthSensorsNamed({"kinect_v1"}));
  EXPECT_EQ(ideal.view.depth_m, ViewOfCarton(*solid, {}).view.depth_m);
  EXPECT_NE(noisy.view.depth_m, ideal.view.depth_m);
  EXPECT_THROW(DepthSensorsNamed({"kinect_v9"}), InputError);
}

TEST(TrueVolume, IsFullExactlyWhereTheSolidIs) {
  const auto solid = Carton();
  const RandomView drawn = ViewOfCarton(*solid, {});
  CompletedVolume cells;
  cells.size = 16;
  cells.cell_m = 1.2f * solid->box_O().diagonal().norm() / 16;
  cells.origin_C = (drawn.X_CO * solid->box_O().center().cast<double>()).cast<float>() -
                   Eigen::Vector3f::Constant(8 * cells.cell_m);
  cells.occupancy.assign(16 * 16 * 16, 0);
  const CompletedVolume truth = TrueVolume(*solid, drawn, cells);
  double volume_m3 = 0;
  for (const float value : truth.occupancy) volume_m3 += value * std::pow(cells.cell_m, 3);
  const Eigen::Vector3f sizes = solid->box_O().sizes();
  EXPECT_NEAR(volume_m3 / sizes.prod(), 1, 0.1);
}

TEST(DrawVolume, AnEmptyVolumeIsWhiteAndAFullOneIsNot) {
  CompletedVolume volume;
  volume.size = 8;
  volume.cell_m = 0.01f;
  volume.occupancy.assign(512, 0);
  const Image<Rgb8> empty = DrawVolume(volume, 0.5f, false, 16);
  EXPECT_EQ(empty(8, 8), (Rgb8{255, 255, 255}));
  volume.occupancy.assign(512, 1);
  EXPECT_NE(DrawVolume(volume, 0.5f, true, 16)(8, 8), empty(8, 8));
}

TEST(CompletionTrainingPage, HasASheetForEachSplitAndTheCurves) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "completion_page";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  CompletionJob job;
  job.domains = {ShapeDomain::kSupermarket};
  job.model_file = folder / "tiny.net";
  CompletionTrainingOptions options;
  options.network.width_16 = options.network.width_8 = options.network.width_4 = 4;
  options.network.bottleneck = 4;
  options.steps = options.batch = options.held_out = 2;
  options.window = 1;
  options.points = 16;
  options.views.max_diameter_px = 40;
  const CompletionReport report = TrainCompletion(job, options);
  ASSERT_TRUE(report.finished);
  const std::string reason =
      WriteCompletionTrainingPage(folder, {job.model_file, job, options, report, "steps: 2"});
  EXPECT_THAT(reason, ::testing::AnyOf("", ::testing::HasSubstr("template")));
  for (const char* split : {"seen", "unseen_sizes", "outside", "unseen_families"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string("completions_") + split + ".png")));
  }
  const std::string csv = ReadFileBytes(folder / "completion_curves.csv");
  EXPECT_THAT(csv,
              ::testing::StartsWith("step,split,cross_entropy,iou_clean,iou_occluded\n0,seen"));
  EXPECT_THAT(csv, ::testing::HasSubstr("\n2,unseen_families,"));
}

}  // namespace
}  // namespace pickbed::eval
