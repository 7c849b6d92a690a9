#include "eval/benchmark/grasp_gallery.h"

#include <gtest/gtest.h>

#include "tests/eval/cube_scenario.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

// A cube of matter at one end of a grid of 8 cells of 1 cm, whose corner is at x.
grasp::OccupancyShape ShapeAt(double x) {
  grasp::OccupancyShape shape;
  shape.X_WV.translation().x() = x;
  shape.cell_m = 0.01;
  shape.size = 8;
  shape.occupancy.assign(512, 0);
  shape.occupancy[0] = 1;
  return shape;
}

TEST(GraspGallery, AGraspIsForTheShapeWithTheNearestMatter) {
  const std::vector<grasp::OccupancyShape> shapes{ShapeAt(0), ShapeAt(0.05)};
  Grasp grasp;
  EXPECT_EQ(GraspedShape({}, grasp), nullptr);
  EXPECT_EQ(GraspedShape(shapes, grasp), &shapes[0]);
  // Within the grid of the first shape, but nearer to the matter of the second one.
  grasp.X_WG.translation().x() = 0.04;
  EXPECT_EQ(GraspedShape(shapes, grasp), &shapes[1]);
}

// The middle of the rod is far from its end, at which the grasp is.
TEST(GraspGallery, AGraspAtTheEndOfARodIsForTheRod) {
  grasp::OccupancyShape rod = ShapeAt(0);
  for (int x = 0; x < rod.size; ++x) rod.occupancy[x] = 1;
  const std::vector<grasp::OccupancyShape> shapes{ShapeAt(-0.02), rod};
  Grasp grasp;
  grasp.X_WG.translation() = Eigen::Vector3d::Constant(0.005);
  EXPECT_EQ(GraspedShape(shapes, grasp), &shapes[1]);
}

// Number of pixels in a column of tiles that are not white.
int DrawnPixels(const Image<Rgb8>& picture, int tile) {
  const int height = picture.height();  // tiles are squares with gaps
  const int begin = tile * (picture.width() - height) / 3;
  int count = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = begin; x < begin + height; ++x) {
      const Rgb8 color = picture(x, y);
      count += color.r < 255 || color.g < 255 || color.b < 255;
    }
  }
  return count;
}

TEST(GraspGallery, APickOnTrueShapesShowsTheCubeFromTwoSides) {
  ScenarioSpec spec = CubeScenario(3);
  spec.planner.name = "completed";
  spec.planner.completion = kTrueShapes;
  GraspPictures pictures(spec);
  TrialRunner(spec, EasyCube()).Run(BinIndex(0), &pictures);
  const std::vector<GraspTile> tiles = pictures.TakeTiles();
  ASSERT_FALSE(tiles.empty());
  EXPECT_LE(tiles.size(),
            static_cast<size_t>(GraspPictures::kMaxSucceeded + GraspPictures::kMaxFailed));
  int succeeded = 0;
  for (const GraspTile& tile : tiles) {
    succeeded += tile.succeeded;
    const int area = tile.picture.height() * tile.picture.height();
    EXPECT_GT(DrawnPixels(tile.picture, 0), area / 2) << "segments";
    EXPECT_GT(DrawnPixels(tile.picture, 1), area / 20) << "from the camera";
    EXPECT_GT(DrawnPixels(tile.picture, 2), area / 20) << "from the side";
    EXPECT_GT(DrawnPixels(tile.picture, 3), area / 2) << "hand";
  }
  EXPECT_EQ(succeeded, 1) << "three cubes are picked, and one success is shown";
  EXPECT_TRUE(pictures.TakeTiles().empty());
}

}  // namespace
}  // namespace pickbed::tests
