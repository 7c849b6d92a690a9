#include "eval/benchmark/crops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/benchmark/crops_report.h"
#include "scenes/base/files.h"
#include "scenes/objects/object_catalog.h"
#include "sim/training_view_source.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

ObjectSet CatalogObjects(const std::vector<std::string>& names) {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  ObjectSet objects;
  for (const std::string& name : names) objects.push_back(catalog.Load(name));
  return objects;
}

CropBenchmarkJob SmallJob() {
  CropBenchmarkJob job{CatalogObjects({"bracket", "hex_bolt"}),
                       {"hog", "linemod", "random"},
                       {"clean"},
                       {},
                       {},
                       1,
                       {}};
  job.options.tests = 12;
  job.options.icp_starts = 2;
  job.options.views.template_level = 2;
  job.options.views.train_level = 3;
  return job;
}

CropStatistics Clean(const CropBenchmark& benchmark, const std::string& method, CropStage stage) {
  return StatisticsOf(benchmark, {method, stage, 0, {}});
}

TEST(CropBenchmark, MethodsScoreBetweenRandomAndNearestTemplate) {
  const CropBenchmarkJob job = SmallJob();
  const CropBenchmark benchmark = RunCropBenchmark(job);
  ASSERT_TRUE(benchmark.finished);
  const CropStatistics oracle = Clean(benchmark, kOracleMethod, CropStage::kNearest);
  const CropStatistics chance = Clean(benchmark, "random", CropStage::kNearest);
  ASSERT_EQ(oracle.tests(), 24);
  // In each view no look-up is better than the template nearest to the ground truth. That template
  // is at most half the spacing of 162 directions away, about 20 degrees of rotation.
  for (int i = 0; i < 24; ++i) EXPECT_LE(oracle.angles_deg[i][0], 20);
  EXPECT_EQ(RateOf(oracle.object_right), 1);
  for (const char* name : {"hog", "linemod"}) {
    SCOPED_TRACE(name);
    const CropStatistics method = Clean(benchmark, name, CropStage::kNearest);
    for (int i = 0; i < 24; ++i) {
      EXPECT_LE(oracle.angles_deg[i][0], method.angles_deg[i][0] + 1e-9);
    }
    EXPECT_GT(RateOf(method.object_right), RateOf(chance.object_right));
    EXPECT_GT(RateOf(method.within[3]), RateOf(chance.within[3]));
  }
  // ICP converges from starts this close.
  const CropStatistics refined = Clean(benchmark, kOracleMethod, CropStage::kNearestIcp);
  EXPECT_LT(MedianOf(refined.angles_deg), MedianOf(oracle.angles_deg));
}

TEST(CropBenchmark, TablesDependOnTheSeedAndNotOnThreads) {
  CropBenchmarkJob job = SmallJob();
  job.methods = {"hog", "linemod", "random"};
  job.conditions = {"noisy", "background"};
  job.options.tests = 5;
  const auto tables = [&] {
    const CropBenchmark benchmark = RunCropBenchmark(job);
    return CropTableCsv(benchmark, job.objects) + CropViewsCsv(benchmark, job.objects) +
           CropDifferencesCsv(benchmark);
  };
  const std::string once = tables();
  job.threads = 2;
  EXPECT_EQ(once, tables());
  job.options.seed = 1;
  EXPECT_NE(once, tables());
}

TEST(CropBenchmark, UnknownNamesAreRefused) {
  CropBenchmarkJob job = SmallJob();
  job.methods = {"hogg"};
  EXPECT_THAT(ErrorOf([&] { RunCropBenchmark(job); }), HasSubstr("did you mean 'hog'?"));
  job = SmallJob();
  job.conditions = {"dark"};
  EXPECT_THAT(ErrorOf([&] { RunCropBenchmark(job); }), HasSubstr("unknown condition 'dark'"));
}

TEST(CropBenchmark, OutOfRangeSettingsReportTheRange) {
  CropBenchmarkOptions options;
  const auto set = [&](const std::string& text) {
    return ErrorOf([&] { ApplySetting(text, [&](SettingsVisitor& v) { options.Visit(v); }); });
  };
  EXPECT_THAT(set("k=0"), HasSubstr("100"));
  EXPECT_THAT(set("views.side_diameters=9"), HasSubstr("5"));
  EXPECT_THAT(set("methods.wohlhart.descriptor=1"), HasSubstr("1024"));
  EXPECT_THAT(set("methods.wohlhart.margin=0"), HasSubstr("10"));
}

// In the planted record the object is wrong, so the pose is wrong too.
TEST(CropStatistics, WrongObjectIsWithinNoAngle) {
  CropBenchmark benchmark;
  CropRecord right{"m", CropStage::kNearest, ObjectId{0}, 0, 0};
  right.found_object = ObjectId{0};
  right.angle_rad = 7 * std::numbers::pi / 180;
  CropRecord wrong = right;
  wrong.test = 1;
  wrong.found_object = ObjectId{1};
  wrong.angle_rad = std::numeric_limits<double>::infinity();
  benchmark.records = {right, wrong};
  const CropStatistics f = StatisticsOf(benchmark, {"m", CropStage::kNearest, 0, {}});
  EXPECT_EQ(RateOf(f.object_right), 0.5);
  EXPECT_EQ(RateOf(f.within[0]), 0);
  EXPECT_EQ(RateOf(f.within[1]), 0.5);
  EXPECT_EQ(RateOf(f.within[3]), 0.5);
  EXPECT_EQ(RateOf(f.over_15_deg), 0.5);
  EXPECT_NEAR(MedianOf(f.angles_deg), 7, 1e-9);
}

class CropConditions : public testing::Test {
 protected:
  CropConditions() {
    ViewSourceOptions options;
    options.appearance = FixedAppearance();
    source_ = MakeSimViewSource(CatalogObjects({"bracket", "elbow", "hex_bolt"}), options);
    options.isolated_lamps = true;
    options.appearance = WideAppearance();
    relit_ = MakeSimViewSource(source_->objects(), options);
  }
  std::vector<CropTest> Tests(const std::string& condition) {
    for (const CropCondition& row : CropConditionTable()) {
      if (row.name != condition) continue;
      Rng rng(4);
      const Rotations R_CO = TestRotations(10, views_, rng);
      return MakeCropTests({source_.get(), source_.get(), relit_.get()}, ObjectId{0}, row, R_CO,
                           views_, 7);
    }
    return {};
  }
  CropViewOptions views_;
  std::unique_ptr<LabelledViewSource> source_, relit_;
};

// Hidden pixels are counted against the same view without an occluder.
TEST_F(CropConditions, OcclusionHidesTheStatedFraction) {
  const std::vector<CropTest> clean = Tests("clean");
  for (const auto& [name, share] : {std::pair{"occluded_10", 0.1}, std::pair{"occluded_50", 0.5}}) {
    const std::vector<CropTest> occluded = Tests(name);
    double mean = 0;
    for (size_t i = 0; i < clean.size(); ++i) {
      int visible = 0, hidden = 0;
      for (size_t p = 0; p < clean[i].frame.depth_m.size(); ++p) {
        const float isolated_m = clean[i].frame.depth_m.data()[p];
        if (isolated_m <= 0) continue;
        ++visible;
        const float seen_m = occluded[i].frame.depth_m.data()[p];
        EXPECT_LE(seen_m, isolated_m);
        hidden += seen_m < isolated_m;
      }
      EXPECT_NEAR(1.0 * hidden / visible, occluded[i].occluded, 1e-9);
      mean += 1.0 * hidden / visible / clean.size();
    }
    EXPECT_NEAR(mean, share, 0.03) << name;
  }
}

TEST_F(CropConditions, BackgroundHidesNothingAndLeavesNoHole) {
  const std::vector<CropTest> clean = Tests("clean"), behind = Tests("background");
  for (size_t i = 0; i < clean.size(); ++i) {
    for (size_t p = 0; p < clean[i].frame.depth_m.size(); ++p) {
      const float isolated_m = clean[i].frame.depth_m.data()[p];
      const float seen_m = behind[i].frame.depth_m.data()[p];
      ASSERT_GT(seen_m, 0);
      if (isolated_m > 0) {
        ASSERT_EQ(seen_m, isolated_m);
      }
    }
  }
}

TEST_F(CropConditions, RelightingChangesOnlyTheColor) {
  const std::vector<CropTest> clean = Tests("clean"), relit = Tests("relit");
  // The relit scene is rotated so that the frame of the lamp is upright, which rounds differently.
  size_t same = 0;
  for (size_t p = 0; p < clean[0].frame.depth_m.size(); ++p) {
    const float a_m = clean[0].frame.depth_m.data()[p], b_m = relit[0].frame.depth_m.data()[p];
    same += std::abs(a_m - b_m) < 1e-5;
  }
  EXPECT_GE(same, 0.999 * clean[0].frame.depth_m.size());
  EXPECT_NE(clean[0].frame.color, relit[0].frame.color);
}

}  // namespace
}  // namespace pickbed::tests
