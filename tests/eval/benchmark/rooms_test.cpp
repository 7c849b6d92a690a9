#include "eval/benchmark/rooms.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "eval/benchmark/rooms_pictures.h"
#include "eval/benchmark/rooms_poses.h"
#include "eval/metrics/metric_table.h"
#include "eval/train/job.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "tests/support/ray_cast_views.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

RoomsRow RowOf(const std::vector<RoomsRow>& rows, const std::string& rooms,
               const std::string& background) {
  for (const RoomsRow& row : rows) {
    if (row.rooms == rooms && row.background == background) return row;
  }
  ADD_FAILURE() << rooms << " " << background << " is absent";
  return {};
}

// The same image is estimated without and with the given bin.
TEST(EstimateRooms, CountsImagesInstancesAndPoses) {
  RayCastViews views({ObjectOf(BracketMesh())});
  EstimatorSpec spec;
  spec.name = "ppf";
  spec.mode = "fast";
  spec.min_score = 0.3;
  RoomsOptions options;
  options.bins = 1;
  options.tables = 0;
  options.empty = 0;
  int calls = 0;
  const std::vector<RoomEstimate> estimates =
      EstimateRooms(views, spec, options, {[&](int done, int total) {
                      EXPECT_EQ(done, calls++);
                      EXPECT_EQ(total, 1);
                      return true;
                    }});
  const std::vector<RoomsRow> rows = RoomsRowsOf(estimates, spec.min_score);
  const RoomsRow bin = RowOf(rows, "bin", "all"), given = RowOf(rows, "bin", "given");
  EXPECT_EQ(bin.images, 1);
  EXPECT_GT(bin.instances, 0);
  EXPECT_EQ(given.instances, bin.instances);
  EXPECT_LE(bin.recalled, bin.instances);
  EXPECT_LE(bin.right, bin.poses);
  const RoomsRow all = RowOf(rows, "all", "given");
  EXPECT_EQ(all.images, 1);
  EXPECT_EQ(all.poses, given.poses);
  // No plane is found, and in every second image none is looked for.
  EXPECT_EQ(RowOf(rows, "all", "unknown").images, 2);
  EXPECT_TRUE(EstimateRooms(views, spec, options, {[](int, int) { return false; }}).empty());
}

// A pose below the minimum score recalls nothing, but it counts for the calibration.
TEST(RoomsRowsOf, ReportsPosesFromTheMinimumScore) {
  RoomEstimate estimate{"bin", kFittedBackground};
  estimate.image.score.instances.resize(2);
  for (InstanceRecord& instance : estimate.image.score.instances) {
    instance.visible_fraction = 1;
    instance.recalled = true;
  }
  for (const double score : {0.8, 0.4}) {
    ScoredHypothesis& pose = estimate.image.score.hypotheses.emplace_back();
    pose.record.score = score;
    pose.record.metrics = InfiniteMetrics();
    pose.recalled = score > 0.5 ? 0 : 1;
  }
  const RoomsRow row = RowOf(RoomsRowsOf({estimate}, 0.5), "bin", "all");
  EXPECT_EQ(row.poses, 1);
  EXPECT_EQ(row.right, 1);
  EXPECT_EQ(row.instances, 2);
  EXPECT_EQ(row.recalled, 1);
  EXPECT_NEAR(row.calibration_error.value, (0.2 + 0.6) / 2, 1e-12);
}

// So the folder of the pictures has only images with wrong poses.
TEST(WriteRoomWithWrongPoses, OnlyWrongReportedPosesGiveAPicture) {
  const TemporaryFolder folder;
  RayCastViews views({ObjectOf(BracketMesh())});
  const LabelledView view = views.ClutterScene({1, 1}).front();
  RoomEstimate estimate{"table", kUnknownBackground, false};
  estimate.image.trial = 7;
  estimate.image.score.instances.resize(1);
  ScoredHypothesis& right = estimate.image.score.hypotheses.emplace_back();
  right.estimate.X_CO = view.instances[0].X_CO;
  right.record.score = 0.9;
  right.recalled = 0;
  ScoredHypothesis wrong = right;
  wrong.record.score = 0.4;
  wrong.recalled = -1;
  estimate.image.score.hypotheses.push_back(wrong);
  EXPECT_FALSE(
      WriteRoomWithWrongPoses(folder.path() / "few", views.objects(), view, estimate, 0.5));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "few"));
  EXPECT_TRUE(WriteRoomWithWrongPoses(folder.path() / "all", views.objects(), view, estimate, 0.3));
  const Image<Rgb8> picture = ReadPng(folder.path() / "all" / "007_table_unknown_planes_off.png");
  EXPECT_EQ(picture.width(), view.frame.intrinsics.width());
  WritePng(folder.path() / "all" / "007.png", picture);
  RemoveRoomPictures(folder.path() / "all");
  EXPECT_EQ(StemsIn(folder.path() / "all", ".png"), std::vector<std::string>{"007"});
}

// A box with a diagonal of 130 mm at 0.5 m has the diameter f * 0.26 in the image.
TEST(RoomPosesLines, GiveTheDiameterInTheImageAndWhetherAPoseIsRight) {
  RayCastViews views({ObjectOf(BoxMesh({0.03, 0.04, 0.12}, {0, 0, 0}))});
  const LabelledView view = views.ClutterScene({1, 1}).front();
  RoomEstimate estimate{"table", kUnknownBackground, false};
  estimate.image.trial = 7;
  for (const int recalled : {0, -1}) {
    ScoredHypothesis& pose = estimate.image.score.hypotheses.emplace_back();
    pose.estimate.X_CO = Translation({0.1, 0, 0.5});
    pose.record.score = 0.75;
    pose.recalled = recalled;
  }
  const double diameter_px = view.frame.intrinsics.fx() * 0.26;
  const std::string start =
      fmt::format("7,table,unknown,0,{},0.7500,{:.1f},", views.objects()[0]->name, diameter_px);
  EXPECT_EQ(RoomPosesLines(views.objects(), view, estimate), start + "1\n" + start + "0\n");
}

// Walls, tables and boxes look like hidden mugs to a verifier that has seen only bins: it reports
// 17 poses in 6 such rooms.
TEST(EstimateRooms, ShippedVerifiersReportNothingInEmptyRooms) {
  TrainingSetChoice choice;
  choice.objects = {"mug"};
  EstimatorSpec spec;
  spec.mode = "fast";
  RoomsOptions options;
  options.bins = options.tables = 0;
  options.empty = 4;
  const auto views = MakeTrainingViews(PlanTrainingSet(choice));
  const std::vector<RoomsRow> rows = RoomsRowsOf(
      EstimateRooms(*views, spec, options, {[](int, int) { return true; }}), spec.min_score);
  EXPECT_EQ(RowOf(rows, "empty", "all").images, 4);
  EXPECT_LE(RowOf(rows, "empty", "all").poses, 1);
}

// Raises the probabilities to a power.
ForecastClusters Raised(ForecastClusters forecasts, double exponent) {
  for (auto& image : forecasts) {
    for (ForecastOutcome& forecast : image) {
      forecast.probability = std::pow(forecast.probability, exponent);
    }
  }
  return forecasts;
}

// Returns the scores of one kind of background and whether the poses are right, by image.
ForecastClusters RoomForecasts(const std::vector<RoomEstimate>& estimates,
                               const std::string& background) {
  ForecastClusters forecasts;
  for (const RoomEstimate& estimate : estimates) {
    if (estimate.background != background) continue;
    std::vector<ForecastOutcome>& image = forecasts.emplace_back();
    for (const ScoredHypothesis& pose : estimate.image.score.hypotheses) {
      image.push_back({pose.record.score, pose.recalled >= 0});
    }
  }
  return forecasts;
}

// For each kind of background, the interval of the calibration error includes 0, so the scores may
// be probabilities. It does not include 0 for a planted error. This takes some seconds, because it
// needs about 20 estimates.
TEST(EstimateRooms, ScoresAreReliableForEachBackground) {
  constexpr double kBound = 0.01;
  constexpr double kPlantedExponent = 16;  // 0.95 becomes 0.44
  TrainingSetChoice choice;
  choice.objects = {"bracket"};
  EstimatorSpec spec;
  spec.mode = "fast";
  RoomsOptions options;
  options.bins = 5;
  options.tables = 4;
  options.empty = 0;
  const auto views = MakeTrainingViews(PlanTrainingSet(choice));
  const std::vector<RoomEstimate> estimates =
      EstimateRooms(*views, spec, options, {[](int, int) { return true; }});
  for (const char* background : {kGivenBackground, kFittedBackground, kUnknownBackground}) {
    SCOPED_TRACE(background);
    const ForecastClusters forecasts = RoomForecasts(estimates, background);
    const Interval error = QualityOf(forecasts).calibration_error.ci95;
    EXPECT_TRUE(error.is_known());
    EXPECT_LT(error.low, kBound);
    const Interval planted = QualityOf(Raised(forecasts, kPlantedExponent)).calibration_error.ci95;
    EXPECT_GT(planted.low, kBound);
  }
}

TEST(RoomsText, ShowsRates) {
  RoomsRow row{"bin", "all"};
  row.images = 4;
  row.instances = 8;
  row.recalled = 6;
  row.poses = 10;
  row.right = 5;
  row.calibration_error = {0.0625, {0.01, 0.125}};
  const std::string text = RoomsText({row});
  EXPECT_THAT(text, HasSubstr("0.750"));  // recall
  EXPECT_THAT(text, HasSubstr("0.500"));  // precision
  EXPECT_THAT(text, HasSubstr("1.250"));  // false poses per image
  EXPECT_THAT(RoomsCsv({row}), HasSubstr("bin,all,4,8,6,10,5,0.0625,0.0100,0.1250,0.0000\n"));
  EXPECT_THAT(text, HasSubstr("0.062 [0.010, 0.125]"));
  row.calibration_error.ci95 = Interval::Unknown();
  EXPECT_THAT(RoomsCsv({row}), HasSubstr("0.0625,,,0.0000\n"));
}

}  // namespace
}  // namespace pickbed::tests
