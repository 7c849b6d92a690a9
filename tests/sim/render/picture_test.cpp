#include "sim/render/picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/sim/render_support.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

constexpr double kCube_m = 0.06;

ObjectSet Cubes(double density_kgpm3) {
  auto model = std::make_shared<ObjectModel>();
  model->name = "cube";
  model->mesh_O = BoxMesh({kCube_m, kCube_m, kCube_m});
  model->mass = UniformMassProperties(model->mesh_O, density_kgpm3 * kCube_m * kCube_m * kCube_m);
  return {model};
}

// Two cubes on the floor of a bin, seen from above.
Scene TwoCubes() {
  Scene scene;
  scene.objects = {{InstanceId{0}, ObjectId{0}, Translation({-0.08, 0, kCube_m / 2})},
                   {InstanceId{4}, ObjectId{0}, Translation({0.08, 0, kCube_m / 2})}};
  return scene;
}

Camera OverheadCamera() {
  return {{160, 120, 150, 150, 79.5, 59.5},
          LookAt({0, -0.01, 0.8}, {0, 0, 0}, Eigen::Vector3d::UnitY())};
}

int Brightness(const Rgb8& c) { return c.r + c.g + c.b; }

class PictureTest : public testing::Test {
 protected:
  Picture Draw(const PictureOptions& options = {}) {
    return pictures_.Render(scene_, camera_, options);
  }

  const ObjectSet objects_ = Cubes(1000);
  const Scene scene_ = TwoCubes();
  const Camera camera_ = OverheadCamera();
  SceneRenderer renderer_{objects_, scene_.bin};
  PictureRenderer pictures_{renderer_, objects_};
};

TEST_F(PictureTest, IdsEqualThoseOfTheSensorImage) {
  const Picture picture = Draw({.scale = 1, .samples = 1});
  EXPECT_EQ(picture.ids, renderer_.Render(scene_, camera_).ids);
  EXPECT_EQ(picture.camera.intrinsics, camera_.intrinsics);
  EXPECT_EQ(picture.color.width(), 160);
}

TEST_F(PictureTest, OptionsOutOfRangeAreRefused) {
  EXPECT_THROW(Draw({.scale = 0}), std::logic_error);
  EXPECT_THROW(Draw({.samples = 9}), std::logic_error);
  EXPECT_THROW(Draw({.threads = 0}), std::logic_error);
}

TEST_F(PictureTest, FurtherInstancesHaveMaterialsOfTheirOwn) {
  const int mesh = renderer_.renderer().AddMesh(BoxMesh({kCube_m, kCube_m, kCube_m}));
  const Eigen::Vector3d right_W(0.08, 0, 0.15), left_W(-0.08, 0, 0.15);
  const std::vector<PictureInstance> more{
      {{mesh, Translation(left_W), 100}, {Finish::kMatte, {0.8f, 0.02f, 0.02f}}},
      {{mesh, Translation(right_W), 101}, {Finish::kMatte, {0.02f, 0.02f, 0.8f}}}};
  const Picture picture = pictures_.Render(scene_, camera_, {.scale = 1, .samples = 1}, more);
  const auto color_at = [&](const Eigen::Vector3d& p_W) {
    const Eigen::Vector2d p = Project(camera_.intrinsics, camera_.X_CW() * p_W);
    return picture.color(std::lround(p.x()), std::lround(p.y()));
  };
  EXPECT_GT(color_at(left_W).r, 2 * color_at(left_W).b);
  EXPECT_GT(color_at(right_W).b, 2 * color_at(right_W).r);
}

// A point keeps its place in the scene: pixel (u, v) covers pixels 2u and 2u + 1 of the picture.
TEST_F(PictureTest, ScaledPictureShowsTheSameView) {
  const Image<uint16_t> small = renderer_.Render(scene_, camera_).ids;
  const Picture picture = Draw({.scale = 2, .samples = 2});
  ASSERT_EQ(picture.color.height(), 240);
  int different = 0;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) different += picture.ids(2 * u + 1, 2 * v + 1) != small(u, v);
  }
  EXPECT_LT(different, 160);  // only pixels on edges
}

TEST_F(PictureTest, TableFillsTheBackground) {
  const Picture picture = Draw();
  for (const Rgb8& pixel : picture.color.pixels()) ASSERT_GT(Brightness(pixel), 20);
  EXPECT_GT(Brightness(picture.color(4, 4)), 250);
}

// The floor beside a cube sees less of the surroundings than the same place in an empty bin.
TEST_F(PictureTest, FloorIsDarkerBesideACube) {
  // On the side of the lamp, so that the shadow is on the other side.
  const Eigen::Vector3d beside_W(-0.08, -kCube_m / 2 - 0.006, 0);
  const Eigen::Vector2d p = Project(camera_.intrinsics, camera_.X_CW() * beside_W);
  const auto at_place = [&](const Picture& picture) {
    return Brightness(picture.color(std::lround(p.x()), std::lround(p.y())));
  };
  const PictureOptions options{.scale = 1, .samples = 1};
  Scene empty = scene_;
  empty.objects.clear();
  EXPECT_LT(at_place(Draw(options)), 0.98 * at_place(pictures_.Render(empty, camera_, options)));
}

TEST_F(PictureTest, ThreadsDoNotChangeThePicture) {
  EXPECT_EQ(Draw({.threads = 1}).color, Draw({.threads = 3}).color);
}

// Pictures use the renderer of the sensor images.
TEST_F(PictureTest, SensorImageIsTheSameBeforeAndAfterAPicture) {
  const RenderedImage before = renderer_.Render(scene_, camera_);
  Draw();
  const RenderedImage after = renderer_.Render(scene_, camera_);
  EXPECT_EQ(before.depth_m, after.depth_m);
  EXPECT_EQ(before.color, after.color);
  EXPECT_EQ(before.ids, after.ids);
}

TEST(PictureMaterial, ColorOfTheMeshIsKept) {
  ObjectModel red = *Cubes(1000)[0];
  red.mesh_O.base_color = {200, 40, 40};
  const Eigen::Vector3f color = PictureMaterialOf(red).color;
  EXPECT_GT(color.x(), 4 * color.y());
  EXPECT_GT(color.y(), 0);
}

TEST(PictureMaterial, DarkMetalIsBrightened) {
  ObjectModel dark = *Cubes(7800)[0];
  dark.mesh_O.base_color = {40, 40, 44};
  EXPECT_GT(PictureMaterialOf(dark).color.minCoeff(), 0.2f);
  dark.mesh_O.base_color = {0, 0, 0};
  EXPECT_GT(PictureMaterialOf(dark).color.minCoeff(), 0.2f);
  dark.mesh_O.base_color = {0, 0, 4};
  EXPECT_LE(PictureMaterialOf(dark).color.maxCoeff(), 1);
  dark = *Cubes(1000)[0];
  dark.mesh_O.base_color = {40, 40, 44};
  EXPECT_LT(PictureMaterialOf(dark).color.maxCoeff(), 0.05f);
}

TEST(PictureMaterial, FollowsDensityAndKeepsColorsOfTheMesh) {
  EXPECT_EQ(PictureMaterialOf(*Cubes(300)[0]).finish, Finish::kMatte);
  EXPECT_EQ(PictureMaterialOf(*Cubes(1000)[0]).finish, Finish::kPlastic);
  EXPECT_EQ(PictureMaterialOf(*Cubes(7800)[0]).finish, Finish::kMetal);
  ObjectModel colored = *Cubes(1000)[0];
  colored.mesh_O.colors.assign(colored.mesh_O.vertices.size(), Rgb8{200, 10, 10});
  EXPECT_LT(PictureMaterialOf(colored).color.x(), 0);
}

}  // namespace
}  // namespace pickbed::tests
