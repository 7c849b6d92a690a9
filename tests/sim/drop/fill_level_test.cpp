#include "sim/drop/fill_level.h"

#include <gtest/gtest.h>

#include "tests/sim/physics_objects.h"

namespace pickbed::tests {
namespace {

// A cube of 40 mm in a bin of 0.4 x 0.2 x 0.1 m.
const ObjectSet kCube{BoxObject({0.04, 0.04, 0.04}, 0.1)};
const Bin kStackBin{{0.4, 0.2, 0.1}};

PosedObject CubeAt(int instance, double x, double y, double z) {
  Pose X_WO = Pose::Identity();
  X_WO.translation() = Eigen::Vector3d(x, y, z);
  return {InstanceId(instance), ObjectId(0), X_WO};
}

TEST(MeasureFill, EmptyBinHasNoFillAndNoLayers) {
  const FillStatistics fill = MeasureFill({kStackBin, {}}, kCube);
  EXPECT_EQ(fill.fill_level, 0);
  EXPECT_TRUE(fill.layers.empty());
}

TEST(MeasureFill, FillLevelIsTheMeanSurfaceHeightOverTheInnerHeight) {
  // The cube covers 1/50 of the floor and is 0.4 of the bin's height.
  const FillStatistics one = MeasureFill({kStackBin, {CubeAt(0, 0, 0, 0.02)}}, kCube);
  EXPECT_NEAR(one.fill_level, 0.4 / 50, 1e-4);
  // A second cube on top raises the same cells to 0.8 of the height.
  const FillStatistics two =
      MeasureFill({kStackBin, {CubeAt(0, 0, 0, 0.02), CubeAt(1, 0, 0, 0.06)}}, kCube);
  EXPECT_NEAR(two.fill_level, 0.8 / 50, 1e-4);
}

TEST(MeasureFill, LayersCountFromTheTop) {
  // Three cubes on each other, from bottom to top, and one cube beside them on the floor.
  const Scene scene{kStackBin,
                    {CubeAt(0, 0, 0, 0.02), CubeAt(1, 0, 0, 0.06), CubeAt(2, 0, 0, 0.10),
                     CubeAt(3, 0.15, 0, 0.02)}};
  EXPECT_EQ(MeasureFill(scene, kCube).layers, (std::vector<int>{3, 2, 1, 1}));
}

TEST(MeasureFill, AnInstanceCoveredByLessThanHalfIsInTheTopLayer) {
  const auto layers_at = [](double shift_m) {
    return MeasureFill({kStackBin, {CubeAt(0, 0, 0, 0.02), CubeAt(1, shift_m, 0, 0.06)}}, kCube)
        .layers;
  };
  EXPECT_EQ(layers_at(0.028), (std::vector<int>{1, 1}));  // 30 % covered
  EXPECT_EQ(layers_at(0.012), (std::vector<int>{2, 1}));  // 70 % covered
}

TEST(MeasureFill, NeighborsAboveAndBelowAreThoseThatShareCells) {
  // Three cubes on each other, shifted so that the lowest and the highest share no cell, and one
  // cube beside them.
  const Scene scene{kStackBin,
                    {CubeAt(0, 0, 0, 0.02), CubeAt(1, 0.03, 0, 0.06), CubeAt(2, 0.06, 0, 0.10),
                     CubeAt(3, -0.15, 0, 0.02)}};
  const FillStatistics fill = MeasureFill(scene, kCube);
  EXPECT_EQ(fill.above, (std::vector<int>{1, 1, 0, 0}));
  EXPECT_EQ(fill.below, (std::vector<int>{0, 1, 1, 0}));
}

}  // namespace
}  // namespace pickbed::tests
