#include "eval/completion/measures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "eval/completion/benchmark.h"
#include "eval/completion/benchmark_report.h"
#include "eval/completion/draw.h"
#include "eval/completion/test_shapes.h"
#include "perception/completion/traced_solid.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::eval {
namespace {

constexpr float kRadius_m = 0.05f;

std::unique_ptr<ViewedSolid> Ball() {
  return std::make_unique<TracedSolid>(
      [](std::span<const Eigen::Vector3f> points_O, std::span<float> distances_m) {
        for (size_t i = 0; i < points_O.size(); ++i) {
          distances_m[i] = points_O[i].norm() - kRadius_m;
        }
      },
      Eigen::AlignedBox3f(Eigen::Vector3f::Constant(-kRadius_m),
                          Eigen::Vector3f::Constant(kRadius_m)));
}

struct Case {
  RandomView drawn;
  CompletedVolume truth;
  std::vector<Eigen::Vector3f> surface;
};

Case CaseOf(const ViewedSolid& solid) {
  Rng rng(2);
  RandomViewOptions options;
  options.occluded_share = 0;
  Case made{DrawView(solid, {}, options, rng), {}, {}};
  CompletedVolume cells;
  cells.size = 40;
  cells.cell_m = 0.003f;
  const Eigen::Vector3f center_C = made.drawn.X_CO.translation().cast<float>();
  cells.origin_C = center_C - Eigen::Vector3f::Constant(0.06f);
  cells.occupancy.assign(40 * 40 * 40, 0);
  made.truth = TrueVolume(solid, made.drawn, cells);
  made.surface = TrueSurfacePoints(solid, made.drawn, made.truth);
  return made;
}

int CountOccluded(const SegmentView& view) {
  return static_cast<int>(
      std::ranges::count_if(view.occluders.pixels(), [](uint8_t pixel) { return pixel != 0; }));
}

TEST(CompletionMeasures, TheTruthItselfHasNoError) {
  const auto ball = Ball();
  const Case made = CaseOf(*ball);
  const CompletionMeasures measures =
      MeasureCompletion(made.truth, made.truth, made.surface, made.drawn, 2 * kRadius_m);
  EXPECT_EQ(measures.iou, 1);
  EXPECT_LT(measures.chamfer, 0.015);
  EXPECT_GT(measures.hidden_found, 0.95);
}

TEST(CompletionMeasures, TrueSurfacePointsAreOnTheSphere) {
  const auto ball = Ball();
  const Case made = CaseOf(*ball);
  ASSERT_GT(made.surface.size(), 500u);
  const Eigen::Vector3f center_C = made.drawn.X_CO.translation().cast<float>();
  for (const Eigen::Vector3f& p : made.surface) {
    EXPECT_NEAR((p - center_C).norm(), kRadius_m, 2e-4);
  }
}

TEST(CompletionMeasures, HalfASphereHasHalfTheOverlap) {
  const auto ball = Ball();
  const Case made = CaseOf(*ball);
  CompletedVolume half = made.truth;
  for (int z = half.size / 2; z < half.size; ++z) {
    for (int i = 0; i < half.size * half.size; ++i) {
      half.occupancy[static_cast<size_t>(z) * half.size * half.size + i] = 0;
    }
  }
  const CompletionMeasures measures =
      MeasureCompletion(half, made.truth, made.surface, made.drawn, 2 * kRadius_m);
  EXPECT_NEAR(measures.iou, 0.5, 0.02);
  EXPECT_LT(measures.hidden_found, 0.4);
  EXPECT_GT(measures.chamfer, 0.03);
}

TEST(CompletionMeasures, CalibrationCountsEveryCellThatIsNotZero) {
  const auto ball = Ball();
  const Case made = CaseOf(*ball);
  CompletedVolume even = made.truth;
  std::fill(even.occupancy.begin(), even.occupancy.end(), 0.25f);
  const CompletionMeasures measures =
      MeasureCompletion(even, made.truth, made.surface, made.drawn, 2 * kRadius_m);
  const auto& bin = measures.calibration[2];
  EXPECT_EQ(bin[0], 40 * 40 * 40);
  EXPECT_NEAR(bin[2] / bin[0], 4.0 / 3 * M_PI * std::pow(kRadius_m / 0.12, 3), 0.01);
  EXPECT_EQ(measures.chamfer, 1);
}

TEST(MeshSolid, ABoxIsFullInsideAndEmptyOutside) {
  const auto shapes = TestShapesOf("catalog", 1, "");
  ASSERT_EQ(shapes.size(), 12u);
  const auto carton = std::find_if(shapes.begin(), shapes.end(),
                                   [](const TestShape& shape) { return shape.name == "carton"; });
  ASSERT_NE(carton, shapes.end());
  const Eigen::AlignedBox3f box = carton->solid->box_O();
  const std::vector<Eigen::Vector3f> points{box.center(), box.center() + 0.4f * box.sizes(),
                                            box.center() + 0.6f * box.sizes()};
  std::vector<uint8_t> inside(3);
  carton->solid->Inside(points, inside);
  EXPECT_THAT(inside, ::testing::ElementsAre(1, 1, 0));
  EXPECT_NEAR(carton->solid->LowestAlong(Eigen::Vector3f::UnitX()), box.min().x(), 1e-5);
}

TEST(TestShapes, ASetWithoutMeshesIsEmptyAndAnUnknownSetIsRefused) {
  EXPECT_TRUE(TestShapesOf("ycb", 1, "no/such/folder").empty());
  EXPECT_THROW(TestShapesOf("yvb", 1, ""), InputError);
}

TEST(CompletionBenchmark, TablesHaveEachMethodAndDoNotDependOnTheRun) {
  CompletionBenchmarkOptions options;
  options.methods = {"local_thickness", "skirt"};
  options.sets = {"unseen_families", "ycb"};
  options.shapes = options.views = 1;
  options.cells = 24;
  const auto folder = std::filesystem::path(::testing::TempDir()) / "completion_benchmark";
  const auto files_of = [&](const char* name) {
    const CompletionBenchmark benchmark =
        RunCompletionBenchmark(options, [](int, int) { return true; });
    EXPECT_THAT(benchmark.skipped_sets, ::testing::ElementsAre("ycb"));
    HtmlPage page("Shape completion");
    AddCompletionBenchmark(folder / name, benchmark, options, page);
    EXPECT_THAT(CompletionTableText(benchmark), ::testing::HasSubstr("set ycb is skipped"));
    return ReadFileBytes(folder / name / kCompletionTable) +
           ReadFileBytes(folder / name / kCompletionViews) +
           ReadFileBytes(folder / name / kCompletionCalibration);
  };
  const std::string first = files_of("a");
  EXPECT_THAT(first, ::testing::HasSubstr("\nskirt,unseen_families,occluded,"));
  EXPECT_EQ(first, files_of("b"));
}

TEST(CompletionBenchmark, RefusesRepeatedNamesMissingFoldersAndNoShapes) {
  const auto run = [](const CompletionBenchmarkOptions& options) {
    RunCompletionBenchmark(options, [](int, int) { return false; });
  };
  CompletionBenchmarkOptions options;
  options.methods = {"skirt"};
  options.sets = {"unseen_families"};
  options.shapes = 1;
  EXPECT_NO_THROW(run(options));
  CompletionBenchmarkOptions wrong = options;
  wrong.methods = {"skirt", "mirror", "skirt"};
  EXPECT_THROW(run(wrong), InputError);
  wrong = options;
  wrong.sets = {"unseen_families", "unseen_families"};
  EXPECT_THROW(run(wrong), InputError);
  wrong = options;
  wrong.data_folder = "no/such/folder";
  EXPECT_THROW(run(wrong), InputError);
  wrong = options;
  wrong.sets = {"ycb"};
  EXPECT_THROW(run(wrong), InputError);
}

// A stopped benchmark has shapes of all sets.
TEST(CompletionBenchmark, SetsTakeTurns) {
  CompletionBenchmarkOptions options;
  options.methods = {"skirt"};
  options.sets = {"catalog", "unseen_families"};
  options.shapes = options.views = 1;
  options.cells = 12;
  const CompletionBenchmark benchmark =
      RunCompletionBenchmark(options, [](int done, int) { return done < 4; });
  std::map<std::string, std::set<std::string>> shapes;
  for (const CompletionRow& row : benchmark.rows) shapes[row.set].insert(row.shape);
  EXPECT_EQ(shapes["catalog"].size(), 2u);
  EXPECT_EQ(shapes["unseen_families"].size(), 2u);
  // The gallery shows a clean and an occluded view of each set.
  EXPECT_EQ(benchmark.gallery.at("catalog").size(), 2u);
  EXPECT_EQ(CountOccluded(benchmark.gallery.at("catalog")[0].view), 0);
  EXPECT_GT(CountOccluded(benchmark.gallery.at("catalog")[1].view), 0);
}

// Another training must not replace the shipped model by a worse one, or by one over 3 MB.
TEST(ShippedCompletionModel, IsSmallAndFarBetterThanTheSkirt) {
  EXPECT_LT(std::filesystem::file_size(TrainedFile("completion")), 3'000'000u);
  CompletionBenchmarkOptions options;
  options.methods = {"network", "skirt"};
  options.sets = {"unseen_families"};
  options.shapes = options.views = 1;
  options.cells = 32;
  const CompletionBenchmark benchmark =
      RunCompletionBenchmark(options, [](int, int) { return true; });
  const auto mean_iou = [&](const char* method) {
    const auto iou = [](const CompletionMeasures& m) { return m.iou; };
    return MeanOverShapes(benchmark, method, "unseen_families", false, iou).mean;
  };
  EXPECT_GT(mean_iou("network"), 0.45);
  EXPECT_GT(mean_iou("network"), mean_iou("skirt") + 0.1);
}

// The true shape is right in each cell, whatever the other method says.
TEST(CompletionBenchmark, TheTruthIsAMethod) {
  CompletionBenchmarkOptions options;
  options.methods = {"truth", "skirt"};
  options.sets = {"unseen_families"};
  options.shapes = options.views = 1;
  options.cells = 24;
  const CompletionBenchmark benchmark =
      RunCompletionBenchmark(options, [](int, int) { return true; });
  int rows = 0;
  for (const CompletionRow& row : benchmark.rows) {
    const bool is_truth = row.method == "truth";
    EXPECT_EQ(row.measures.iou == 1, is_truth) << row.shape;
    // Half a cell is 0.5 * 1.35 / 24 of the extent.
    EXPECT_TRUE(!is_truth || row.measures.chamfer < 0.02) << row.shape << row.measures.chamfer;
    rows += is_truth;
  }
  EXPECT_GT(rows, 0);
  options.methods = {"truth"};
  EXPECT_THROW(RunCompletionBenchmark(options, [](int, int) { return true; }), InputError);
}

TEST(CompletionBenchmark, IntervalsStayInTheRangeOfTheirValues) {
  CompletionBenchmark benchmark;
  for (int shape = 0; shape < 5; ++shape) {
    for (const char* method : {"network", "skirt"}) {
      CompletionRow row{method, "seen", std::to_string(shape), false, 0, {}, 0.1};
      const bool is_good = std::string(method) == "network";
      row.measures.iou = is_good ? (shape == 0 ? 0.7 : 1) : (shape == 0 ? 0.3 : 0);
      benchmark.rows.push_back(row);
    }
  }
  const auto iou = [](const CompletionMeasures& m) { return m.iou; };
  const ShapeMean high = MeanOverShapes(benchmark, "network", "seen", false, iou);
  EXPECT_EQ(high.ci95.high, 1);
  EXPECT_LT(high.ci95.low, high.mean);
  EXPECT_GT(high.ci95.low, 0.7);
  const ShapeMean low = MeanOverShapes(benchmark, "skirt", "seen", false, iou);
  EXPECT_EQ(low.ci95.low, 0);
  EXPECT_GT(low.ci95.high, low.mean);
  const ShapeMean more = DifferenceOverShapes(benchmark, "network", "skirt", "seen", false, iou);
  EXPECT_EQ(more.ci95.high, 1);
  const ShapeMean less = DifferenceOverShapes(benchmark, "skirt", "network", "seen", false, iou);
  EXPECT_EQ(less.ci95.low, -1);
}

// The cells of all views of a shape are not independent, and neither are its durations.
TEST(CompletionBenchmark, CalibrationAndSecondsHaveIntervalsOverShapes) {
  CompletionBenchmark benchmark;
  benchmark.methods = {"skirt"};
  benchmark.sets = {"seen"};
  std::vector<Cluster> cells;
  ValueClusters seconds;
  for (int shape = 0; shape < 8; ++shape) {
    const double inside = shape < 4 ? 500 : 0, duration_s = 0.1 * (shape + 1);
    for (const bool is_occluded : {false, true}) {
      CompletionRow row{"skirt", "seen", std::to_string(shape), is_occluded, 0, {}, duration_s};
      row.measures.calibration[5] = {500, 275, inside};
      benchmark.rows.push_back(row);
    }
    cells.push_back({static_cast<int>(2 * inside), 1000});
    seconds.push_back({duration_s, duration_s});
  }
  const auto folder = std::filesystem::path(::testing::TempDir()) / "completion_intervals";
  HtmlPage page("Shape completion");
  AddCompletionBenchmark(folder, benchmark, {}, page);
  const Interval share = ClusterInterval(cells);
  EXPECT_LT(share.low, 0.25) << "8000 independent cells would give 0.489";
  EXPECT_THAT(ReadFileBytes(folder / kCompletionCalibration),
              ::testing::HasSubstr(fmt::format("skirt,seen,0.5500,0.5000,{:.4f},{:.4f},8000\n",
                                               share.low, share.high)));
  EXPECT_THAT(page.body(),
              ::testing::HasSubstr(fmt::format("[{:.2f}, {:.2f}]", share.low, share.high)));
  const Interval duration = MedianInterval(seconds);
  EXPECT_THAT(ReadFileBytes(folder / kCompletionTimings),
              ::testing::HasSubstr(
                  fmt::format("skirt,0.4000,{:.4f},{:.4f}\n", duration.low, duration.high)));
}

TEST(CompletionBenchmark, MeansAndDifferencesAreOverShapes) {
  CompletionBenchmark benchmark;
  for (int shape = 0; shape < 6; ++shape) {
    for (const bool is_skirt : {true, false}) {
      CompletionRow row{
          is_skirt ? "skirt" : "mirror", "seen", std::to_string(shape), false, 0, {}, 0.1};
      row.measures.iou = is_skirt ? 0.1 * shape : 0.1 * shape + 0.2 - 0.02 * shape;
      benchmark.rows.push_back(row);
    }
  }
  const auto iou = [](const CompletionMeasures& m) { return m.iou; };
  const ShapeMean mean = MeanOverShapes(benchmark, "skirt", "seen", false, iou);
  EXPECT_NEAR(mean.mean, 0.25, 1e-12);
  // Student's t with 5 degrees of freedom: 2.571 * sqrt(0.035 / 6).
  EXPECT_NEAR(mean.ci95.high - mean.mean, 0.1963, 1e-3);
  // The differences are 0.2 - 0.02 i, so they have a fifth of the standard deviation.
  const ShapeMean more = DifferenceOverShapes(benchmark, "mirror", "skirt", "seen", false, iou);
  EXPECT_NEAR(more.mean, 0.15, 1e-12);
  EXPECT_NEAR(more.ci95.high - more.mean, 0.2 * 0.1963, 1e-3);
}

}  // namespace
}  // namespace pickbed::eval
