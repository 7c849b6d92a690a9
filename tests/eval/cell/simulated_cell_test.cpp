#include "eval/cell/simulated_cell.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "scenes/scenario/object_pool.h"
#include "tests/eval/cube_scenario.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TEST(SimulatedCell, BinOutsideTheSensorRangeIsRefused) {
  ScenarioSpec spec = CubeScenario(1);
  spec.sensor = "time_of_flight";
  spec.camera.target_m = {0, 0, 0};
  spec.camera.eye_m = {0, -0.3, 0.45};
  EXPECT_NO_THROW(SimulatedCell(spec, EasyCube())) << "0.54 m";
  spec.camera.eye_m = {0, -0.3, 0.39};
  EXPECT_THAT(ErrorOf([&] { SimulatedCell(spec, EasyCube()); }),
              testing::AllOf(HasSubstr("sensor: time_of_flight reads from 0.5 to 4.5 m"),
                             HasSubstr("floor is 0.492 m in front of the camera"),
                             HasSubstr("camera.eye_m")));
  spec.camera.eye_m = {0, -0.3, 4.6};
  EXPECT_THAT(ErrorOf([&] { SimulatedCell(spec, EasyCube()); }), HasSubstr("4.610 m"));
}

TEST(SimulatedCell, PreparesAPoolObjectWhenABinFirstDrawsIt) {
  ScenarioSpec spec = CubeScenario(1);
  ObjectSet pool;
  spec.objects.assign(8, spec.objects[0]);
  for (int i = 0; i < 8; ++i) {
    spec.objects[i].name = fmt::format("cube_{}", i);
    auto mesh_only = std::make_shared<ObjectModel>(*Cube(0.02 + 0.001 * i, 0.05, 0.6));
    mesh_only->convex_pieces_O.clear();
    mesh_only->resting_O.clear();
    pool.push_back(mesh_only);
  }
  spec.draw = 3;
  const auto prepared = [](const SimulatedCell& cell) {
    std::vector<int> each;
    for (const auto& object : cell.objects()) {
      each.push_back(!object->convex_pieces_O.empty() && !object->resting_O.empty());
    }
    return each;
  };
  SimulatedCell cell(spec, pool);
  EXPECT_EQ(prepared(cell), std::vector<int>(8, 0));
  std::vector<std::pair<int, int>> progress;
  cell.SetOnPrepare([&](int done, int total) { progress.emplace_back(done, total); });
  const BinIndex bin_index(2);
  const Scene scene = cell.MakeScene(bin_index).scene;
  EXPECT_EQ(prepared(cell), CountsInBin(spec.objects, 3, spec.seed, bin_index));
  EXPECT_THAT(progress,
              testing::ElementsAre(testing::Pair(1, 3), testing::Pair(2, 3), testing::Pair(3, 3)));
  // The scene does not depend on what was prepared before.
  SimulatedCell all(spec, pool);
  all.PrepareAllObjects();
  EXPECT_EQ(prepared(all), std::vector<int>(8, 1));
  const Scene same = all.MakeScene(bin_index).scene;
  ASSERT_EQ(scene.objects.size(), same.objects.size());
  for (size_t k = 0; k < scene.objects.size(); ++k) {
    EXPECT_EQ(scene.objects[k].object, same.objects[k].object);
    EXPECT_EQ(scene.objects[k].X_WO.matrix(), same.objects[k].X_WO.matrix());
  }
  all.MakeScene(bin_index);
  EXPECT_EQ(progress.size(), 3u);
}

// Physics and image of a bin depend only on what it draws, not on the rest of the pool.
TEST(SimulatedCell, ADrawnBinEqualsABinOfTheDrawnObjects) {
  ScenarioSpec spec = CubeScenario(1);
  ObjectSet pool;
  spec.objects.assign(6, spec.objects[0]);
  for (int i = 0; i < 6; ++i) {
    spec.objects[i].name = fmt::format("cube_{}", i);
    pool.push_back(Cube(0.012 + 0.006 * i, 0.05, 0.6));  // small ones need short time steps
  }
  spec.draw = 3;
  SimulatedCell cell(spec, pool);
  std::set<std::vector<int>> drawn;
  for (int bin = 0; bin < 6; ++bin) {
    const BinIndex bin_index(bin);
    const std::vector<int> counts = CountsInBin(spec.objects, 3, spec.seed, bin_index);
    drawn.insert(counts);
    ScenarioSpec only = spec;
    only.draw = 0;
    only.objects.clear();
    ObjectSet objects;
    for (size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      only.objects.push_back(spec.objects[i]);
      objects.push_back(pool[i]);
    }
    ASSERT_EQ(objects.size(), 3u);
    SimulatedCell same(only, objects);
    const Scene a = cell.MakeScene(bin_index).scene, b = same.MakeScene(bin_index).scene;
    ASSERT_EQ(a.objects.size(), 3u);
    for (size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(pool[a.objects[k].object], objects[b.objects[k].object]);
      EXPECT_EQ(a.objects[k].X_WO.matrix(), b.objects[k].X_WO.matrix());
    }
    EXPECT_EQ(cell.Capture(a, bin_index, 0).frame.depth_m.pixels(),
              same.Capture(b, bin_index, 0).frame.depth_m.pixels());
  }
  EXPECT_GT(drawn.size(), 3u);
}

}  // namespace
}  // namespace pickbed::tests
