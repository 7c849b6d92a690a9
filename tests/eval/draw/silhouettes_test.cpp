#include "eval/draw/silhouettes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "eval/draw/outline.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr CameraIntrinsics kCamera{200, 160, 300, 300, 99.5, 79.5};

// A cube with this edge length, in m, centered at the origin.
TriangleMesh CubeMesh(double edge_m) {
  return BoxesMesh({{Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(edge_m / 2)}});
}

RegionMap MapOf(const std::vector<std::pair<double, Eigen::Vector3d>>& cubes, double tie_m = 0) {
  RegionMap map(kCamera);
  for (const auto& [edge_m, center_C] : cubes) {
    map.Add(RasterMesh(CubeMesh(edge_m)), Translation(center_C), tie_m);
  }
  return map;
}

long PixelsOf(const RegionMap& map, uint16_t id) {
  return std::ranges::count(map.ids().pixels(), id);
}

TEST(RegionMap, HiddenMeshHasNoPixel) {
  for (const bool hidden_first : {true, false}) {
    std::vector<std::pair<double, Eigen::Vector3d>> cubes{{0.04, {0, 0, 0.5}},
                                                          {0.10, {0, 0, 0.35}}};
    if (!hidden_first) std::swap(cubes[0], cubes[1]);
    const RegionMap map = MapOf(cubes);
    const uint16_t hidden = hidden_first ? 1 : 2, front = hidden_first ? 2 : 1;
    EXPECT_EQ(PixelsOf(map, hidden), 0);
    EXPECT_GT(PixelsOf(map, front), 1000);
    EXPECT_TRUE(SilhouettesOf(map.ids(), 2, map.fineness())[hidden - 1].curves.empty());
  }
}

TEST(RegionMap, FirstOfAlmostEqualPosesIsVisible) {
  const std::vector<std::pair<double, Eigen::Vector3d>> cubes{{0.04, {0, 0, 0.5}},
                                                              {0.04, {0, 0, 0.499}}};
  EXPECT_EQ(PixelsOf(MapOf(cubes), 1), 0);
  // Only the border of the nearer cube, which is a little larger in the image.
  const RegionMap map = MapOf(cubes, 0.002);
  EXPECT_GT(PixelsOf(map, 1), 10 * PixelsOf(map, 2));
}

TEST(RegionMap, MeshBehindTheCameraHasNoPixelButAnId) {
  const RegionMap map = MapOf({{0.04, {0, 0, -0.5}}, {0.04, {0, 0, 0.5}}});
  EXPECT_EQ(PixelsOf(map, 1), 0);
  EXPECT_GT(PixelsOf(map, 2), 100);
}

// The front face is 0.04 / 0.48 * 300 = 25 px wide.
TEST(Silhouette, SurroundsItsRegion) {
  const RegionMap map = MapOf({{0.04, {0.05, 0, 0.5}}});
  const Silhouette silhouette = SilhouettesOf(map.ids(), 1, map.fineness())[0];
  ASSERT_EQ(silhouette.curves.size(), 1);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : silhouette.curves[0]) box.extend(p);
  EXPECT_NEAR(box.sizes().y(), 25, 1.5);
  EXPECT_NEAR(box.center().y(), 79.5, 0.7);
  EXPECT_GT(box.min().x(), 99.5 + 300 * 0.03 / 0.52 - 1.5);
  EXPECT_LT(box.max().x(), 99.5 + 300 * 0.07 / 0.48 + 1.5);
  EXPECT_TRUE(box.contains(silhouette.inside));
  EXPECT_NEAR(silhouette.inside_px, 12.5, 1.5);
}

TEST(Silhouette, HoleHasACurveUnlessHolesAreLeftOut) {
  Image<uint16_t> ids(60, 60);
  for (int y = 10; y < 50; ++y) {
    for (int x = 10; x < 50; ++x) ids(x, y) = x > 20 && x < 40 && y > 20 && y < 40 ? 0 : 3;
  }
  EXPECT_EQ(SilhouetteOf(ids, 3, 1).curves.size(), 2);
  EXPECT_EQ(SilhouetteOf(ids, 3, 1, Holes::kWithout).curves.size(), 1);
}

// The nearest camera that sees all points: none is outside the margin, and some touch it on two
// opposite sides.
TEST(CameraAround, SeesAllPointsAndIsNear) {
  const std::vector<Eigen::Vector3d> points_W{
      {0.3, 0, 0}, {-0.2, 0.1, 0.4}, {0, 0.5, 0.2}, {0.1, -0.3, -0.1}};
  const Camera camera = CameraAround(points_W, {0.2, -0.8, 0.7}, 0.1, 200, 150, 250);
  Eigen::AlignedBox2d seen_px;
  for (const Eigen::Vector3d& p_W : points_W) {
    seen_px.extend(Project(camera.intrinsics, camera.X_CW() * p_W));
  }
  // Pixel centers have whole coordinates, so that the image begins at -0.5.
  const Eigen::Vector2d low_px(0.1 * 200 - 0.5, 0.1 * 150 - 0.5);
  const Eigen::Vector2d high_px(0.9 * 200 - 0.5, 0.9 * 150 - 0.5);
  const Eigen::Vector2d room_below_px = seen_px.min() - low_px;
  const Eigen::Vector2d room_above_px = high_px - seen_px.max();
  EXPECT_GT(room_below_px.minCoeff(), -1e-9);
  EXPECT_GT(room_above_px.minCoeff(), -1e-9);
  EXPECT_NEAR(room_below_px.cwiseMax(room_above_px).minCoeff(), 0, 1e-9);
  const std::vector<Eigen::Vector3d> one_point_W{{0.3, 0, 0}};
  EXPECT_THROW(CameraAround(one_point_W, {0, 0, 1}, 0.1, 200, 150, 250), std::logic_error);
  EXPECT_THROW(CameraAround({}, {0, 0, 1}, 0.1, 200, 150, 250), std::logic_error);
}

// Seen from a corner, a cube shows nine of its twelve edges. The other three meet in the corner
// that projects to the center of the image.
TEST(ObjectOutlines, HiddenEdgesAreRemoved) {
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O = CubeMesh(0.1);
  model->diameter_m = 0.1 * std::sqrt(3.0);
  const ObjectSet objects{model};
  const Camera camera = CameraTowards(Eigen::Vector3d::Zero(), {1, 1.1, 0.9}, 0.6, 200, 160, 300);
  ObjectOutlines outlines(objects);
  const Eigen::Vector2d hidden_px =
      Project(camera.intrinsics, camera.X_CW() * Eigen::Vector3d::Constant(-0.05));
  const Eigen::Vector2d edge_px =
      Project(camera.intrinsics, camera.X_CW() * Eigen::Vector3d(-0.05, -0.05, 0.05));
  const Eigen::Vector2d center_px = 0.5 * (hidden_px + edge_px);
  double near_px = 1e9;
  double length_px = 0;
  for (const PixelLine& line : outlines.At(ObjectId(0), camera.X_CW(), camera.intrinsics)) {
    const Eigen::Vector2d center = 0.5 * (line.a + line.b);
    near_px = std::min(near_px, (center - center_px).norm());
    length_px += (line.b - line.a).norm();
  }
  EXPECT_GT(near_px, 3);
  EXPECT_GT(length_px, 9 * 25);
}

}  // namespace
}  // namespace pickbed::tests
