#include "eval/tolerance/pick_forecast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "eval/summary/run_csv.h"
#include "eval/summary/run_summary.h"
#include "grasp/outcome.h"
#include "scenes/base/random.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kTolerated_m = 0.003;

std::shared_ptr<const ObjectModel> Named(const std::string& name, double side_m) {
  ObjectModel model = *Cube(side_m, 0.05, 0.6);
  model.name = name;
  return std::make_shared<ObjectModel>(model);
}

// A model of grasps that tolerate an error of kTolerated_m along x of the object.
ToleranceModel Model(const ObjectModel& object) {
  ToleranceModel model = EmptyToleranceModel(object, "jaw", {Pose::Identity()});
  Rng rng(3);
  std::vector<ToleranceSample> samples;
  for (int i = 0; i < 1000; ++i) {
    PoseOffset error = PoseOffset::Zero();
    for (int k = 0; k < 3; ++k) error[k] = rng.Uniform(-0.01, 0.01);
    samples.push_back({error, std::abs(error[0]) < kTolerated_m, i % 20});
  }
  FitTolerance(samples, {}, model);
  return model;
}

// Bins with two picks each. A pick succeeds if its error along x is below kTolerated_m.
std::vector<TrialResult> Bins(int bins, int objects, double max_error_m) {
  Rng rng(8);
  std::vector<TrialResult> trials(bins);
  for (int t = 0; t < bins; ++t) {
    trials[t].trial = t;
    for (int i = 0; i < 2; ++i) {
      AttemptRecord& pick = trials[t].attempts.emplace_back();
      pick.attempt = i;
      pick.chosen = 0;
      pick.matched_instance = InstanceId{0};
      pick.grasp = Grasp();
      HypothesisRecord& h = pick.hypotheses.emplace_back();
      h.object = ObjectId((t + i) % objects);
      h.instance = InstanceId{0};
      h.metrics.Set(kMssdDiameters, 0.1);
      h.X_OE = Translation(
          {rng.Uniform(-max_error_m, max_error_m), rng.Uniform(-max_error_m, max_error_m), 0});
      const bool is_tolerated = std::abs(h.X_OE.translation().x()) < kTolerated_m;
      pick.outcome.verdicts[static_cast<int>(SuccessRule::kRightInstance)] = is_tolerated;
    }
  }
  return trials;
}

class PickForecasts : public ::testing::Test {
 protected:
  // Writes FOLDER/NAME/model.yaml and returns its folder.
  std::string Map(const std::string& name, const ObjectModel& object,
                  const std::string& gripper = "jaw") {
    const std::filesystem::path folder = folder_.path() / name;
    std::filesystem::create_directories(folder);
    ToleranceModel model = Model(object);
    model.gripper = gripper;
    WriteToleranceModel(folder / "model.yaml", model);
    return folder.string();
  }

  TemporaryFolder folder_;
  const ObjectSet objects_{Named("small", 0.03), Named("large", 0.05)};
};

TEST_F(PickForecasts, MapsAreSelectedByObjectAndGripper) {
  const std::string small = Map("one", *objects_[0]);
  Map("two", *objects_[1]);
  Map("three", *objects_[1], "cup");
  EXPECT_TRUE(ToleranceMaps({}, objects_, "jaw").empty());
  const ToleranceMaps both({folder_.path().string()}, objects_, "jaw");
  EXPECT_EQ(both.Of(ObjectId{0})->object, "small");
  EXPECT_EQ(both.Of(ObjectId{1})->gripper, "jaw");
  const ToleranceMaps one({small + "/model.yaml"}, objects_, "jaw");
  EXPECT_NE(one.Of(ObjectId{0}), nullptr);
  EXPECT_EQ(one.Of(ObjectId{1}), nullptr);
  const auto error = [&](const std::vector<std::string>& places, const std::string& gripper) {
    return ErrorOf([&] { ToleranceMaps(places, objects_, gripper); });
  };
  EXPECT_THAT(error({small}, "cup"),
              HasSubstr("is a map of small with jaw; the objects are small, large"));
  EXPECT_THAT(error({folder_.path().string()}, "hand"), HasSubstr("there is no map"));
  EXPECT_THAT(error({small, small}, "jaw"), HasSubstr("are both maps of small"));
  EXPECT_THAT(error({"nowhere"}, "jaw"), HasSubstr("no such file"));
  std::filesystem::create_directories(folder_.path() / "empty" / "deep");
  EXPECT_THAT(error({(folder_.path() / "empty").string()}, "jaw"), HasSubstr("pickbed tolerance"));
  Map("four", *Named("small", 0.04));
  EXPECT_THAT(error({(folder_.path() / "four").string()}, "jaw"), HasSubstr("another mesh"));
}

TEST_F(PickForecasts, EveryHypothesisHasAPickChance) {
  const ToleranceMaps maps({Map("one", *objects_[0])}, objects_, "jaw");
  HypothesisRecord h;
  h.instance = InstanceId{4};
  h.metrics.Set(kMssdDiameters, 0);
  EXPECT_GT(maps.PickChance(h).value(), 0.9);
  h.X_OE = Translation({0.008, 0, 0});
  EXPECT_LT(maps.PickChance(h).value(), 0.1);
  h.X_OE = Translation({0, 0.008, 0});
  EXPECT_GT(maps.PickChance(h).value(), 0.9);
  h.metrics.Set(kMssdDiameters, 0.6);
  EXPECT_EQ(maps.PickChance(h).value(), 0) << "no instance is at that place";
  h.metrics.Set(kMssdDiameters, 0);
  h.instance = InstanceId{-1};
  EXPECT_EQ(maps.PickChance(h).value(), 0);
  h.object = ObjectId(1);
  EXPECT_FALSE(maps.PickChance(h).has_value());
  const auto trials = Bins(3, 2, 0.01);
  EXPECT_THAT(PickChancesCsv(trials, objects_, maps), Not(HasSubstr("large")));
  EXPECT_THAT(PickChancesCsv(trials, objects_, maps), HasSubstr("\n0,0,0,small,0,0."));
  EXPECT_THAT(AttemptsCsv(trials, {"small", "large"}, maps), HasSubstr(",p_pick,p_grasp,success"));
}

TEST_F(PickForecasts, ForecastMatchesThePicksOfTheRun) {
  Map("one", *objects_[0]);
  Map("two", *objects_[1]);
  const ToleranceMaps maps({folder_.path().string()}, objects_, "jaw");
  auto trials = Bins(120, 2, 0.01);
  trials[0].attempts[0].matched_instance =
      InstanceId{-1};  // a pick at a phantom has no known pose error
  const auto forecasts = ForecastsOf(trials, objects_, maps);
  ASSERT_EQ(forecasts.size(), 3u);
  EXPECT_EQ(forecasts[0].object, "small");
  EXPECT_EQ(forecasts[2].object, "all objects");
  EXPECT_EQ(forecasts[2].picks, 239);
  EXPECT_EQ(forecasts[2].bins, 120);
  EXPECT_EQ(forecasts[0].successes + forecasts[1].successes, forecasts[2].successes);
  for (const PickForecast& f : forecasts) {
    EXPECT_NEAR(f.expected / f.picks, double(f.successes) / f.picks, 0.08);
    EXPECT_EQ(f.predictors[0].name, kPickRiskMetric);
    EXPECT_GT(f.predictors[0].auc.auc, 0.97);
    for (const Predictor& p : f.predictors) {
      if (p.name != "mssd" && p.name != "add" && p.name != "adi") continue;
      EXPECT_LT(p.auc.auc, 0.9) << p.name;
    }
  }
  const std::string text = ForecastText(forecasts);
  EXPECT_THAT(text, HasSubstr("Picks of all objects by their pose errors"));
  EXPECT_THAT(text, Not(HasSubstr("few")));
  EXPECT_THAT(ForecastText(ForecastsOf(Bins(4, 1, 0.01), objects_, maps)), HasSubstr("few"));
  EXPECT_THAT(ForecastText(ForecastsOf(Bins(4, 1, 0.001), objects_, maps)),
              HasSubstr("all 8 picks succeeded"));
  EXPECT_THAT(ForecastJson(ForecastsOf(Bins(4, 1, 0.001), objects_, maps)),
              HasSubstr("\"auc\": null"));
  EXPECT_TRUE(ForecastsOf(trials, objects_, {}).empty());
}

}  // namespace
}  // namespace pickbed::tests
