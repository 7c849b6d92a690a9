#include "eval/trial/clutter.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "eval/summary/clutter_json.h"
#include "eval/summary/run_summary.h"
#include "tests/eval/cube_scenario.h"

namespace pickbed::tests {
namespace {

// Returns the clutter of cubes at these positions of their centers, in cube sides.
ClutterStatistics ClutterOf(const std::vector<Eigen::Vector3d>& centers) {
  TrialOptions perception_given;
  perception_given.truth = {true, true, true, true, false};
  TrialSetup setup(CubeScenario(1), EasyCube(), {}, perception_given);
  const double side_m = MeshBounds(setup.cell.objects()[0]->mesh_O).size().x();
  Scene scene{setup.cell.bin(), {}};
  for (const Eigen::Vector3d& center : centers) {
    Pose X_WO = Pose::Identity();
    X_WO.translation() = side_m * center;
    scene.objects.push_back({InstanceId(scene.objects.size()), ObjectId(0), X_WO});
  }
  const Observation view = setup.cell.Capture(scene, BinIndex(0), 0);
  ClutterStatistics clutter = MeasureClutter(setup.cell, scene, BinIndex(0), view);
  const GraspableCount count = CountGraspable(setup, scene, view.visible_fractions, 100);
  clutter.tested = count.tested;
  clutter.graspable = count.graspable;
  return clutter;
}

TEST(MeasureClutter, ASingleCubeIsVisibleAndGraspable) {
  const ClutterStatistics clutter = ClutterOf({{0, 0, 0.5}});
  EXPECT_EQ(clutter.instances, 1);
  EXPECT_EQ(clutter.layers, (std::vector<int>{1}));
  ASSERT_EQ(clutter.visible_fraction.size(), 1u);
  EXPECT_GT(clutter.visible_fraction[0], 0.99);
  EXPECT_EQ(clutter.counted, 1);
  EXPECT_EQ(clutter.graspable, 1);
}

TEST(MeasureClutter, AJawNeedsTwoOppositeFreeFaces) {
  // In a block of 3 x 3 cubes without gaps, no cube has two opposite free faces.
  std::vector<Eigen::Vector3d> block;
  for (int i = 0; i < 9; ++i) block.emplace_back(i % 3 - 1, i / 3 - 1, 0.5);
  const ClutterStatistics clutter = ClutterOf(block);
  EXPECT_EQ(clutter.counted, 9);
  EXPECT_EQ(clutter.graspable, 0);
  // In a row of two, both have.
  EXPECT_EQ(ClutterOf({{0, 0, 0.5}, {1, 0, 0.5}}).graspable, 2);
}

TEST(MeasureClutter, AHiddenCubeIsNotCounted) {
  const ClutterStatistics clutter =
      ClutterOf({{0, 0, 0.5}, {0, 0, 1.5}, {1, 0, 0.5}, {-1, 0, 0.5}, {0, 1, 0.5}, {0, -1, 0.5}});
  EXPECT_EQ(clutter.counted, 5);
  EXPECT_EQ(clutter.layers, (std::vector<int>{5, 1}));
}

TEST(CountGraspable, TestsNoInstanceForAPlannerWithoutPoses) {
  ScenarioSpec spec = CubeScenario(1);
  spec.planner.name = "cloud_antipodal";
  const TrialSetup setup(spec, EasyCube(), {}, {});
  const Scene scene{setup.cell.bin(), {{InstanceId(0), ObjectId(0), Translation({0, 0, 0.02})}}};
  const std::vector<double> visible{1};
  EXPECT_EQ(CountGraspable(setup, scene, visible, 100).tested, 0);
}

TEST(ClutterText, NamesNoGraspableInstancesWithoutATest) {
  ClutterSummary summary;
  summary.bins = 1;
  summary.in_view.resize(InViewNames().size());
  summary.counted = 7;
  const std::string text = ClutterText(summary, "jaw_8cm");
  EXPECT_NE(text.find("7 instances are at least 10 % visible\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("can be grasped"), std::string::npos);
}

TEST(ClutterJson, CountsEachWantedInstanceInOneBand) {
  ClutterStatistics clutter;
  clutter.instances = 4;
  clutter.layers = {3, 1};
  clutter.visible_fraction = {0.05, 0.4, 0.95, 1.0};
  clutter.counted = 3;
  clutter.tested = 3;
  clutter.graspable = 2;
  const ClutterSummary summary = ClutterOfBin(clutter);
  const auto json = nlohmann::json::parse(ClutterJson(summary, "jaw_8cm"));
  EXPECT_EQ(json.at("in_view").at("0-10"), 1);
  EXPECT_EQ(json.at("in_view").at("30-50"), 1);
  EXPECT_EQ(json.at("in_view").at("90-100"), 2);
  EXPECT_EQ(json.at("graspable"), 2);
  EXPECT_NE(ClutterText(summary, "jaw_8cm").find("2 of 3"), std::string::npos);
}

}  // namespace
}  // namespace pickbed::tests
