#include "sim/render/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scenes/bin/bin.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

// A square of 100 x 100 pixels in front of a camera of 220 x 220 pixels, 1 mm per pixel at its
// depth.
class Visibility : public testing::Test {
 protected:
  Visibility() : camera_(TestCamera(220, 220, 500)) {
    square_ = renderer_.AddMesh(RectangleMesh(-0.05, -0.05, 0.05, 0.05));
  }

  std::vector<double> Fractions(const std::vector<RenderInstance>& instances) {
    const RenderedImage image = renderer_.RenderDepth(camera_, instances);
    return VisibleFractions(renderer_, camera_, instances, image.ids);
  }

  Renderer renderer_;
  Camera camera_;
  int square_ = 0;
};

TEST_F(Visibility, SingleInstanceIsFullyVisible) {
  EXPECT_EQ(Fractions({{square_, Translation({0.01, 0.002, 0.5}), 1}}), std::vector{1.0});
}

TEST_F(Visibility, HalfCoveredSquareHasFractionOneHalf) {
  // The lower edge of the cover passes through the center of the square. The cover is drawn second
  // and is nearer.
  const auto fractions = Fractions(
      {{square_, Translation({0, 0, 0.5}), 1}, {square_, Translation({0, -0.05, 0.4999}), 2}});
  EXPECT_NEAR(fractions[0], 0.5, 0.01);
  EXPECT_EQ(fractions[1], 1.0);
}

// Ids are depth-tested, so it must not matter whether the nearer square is drawn first or last.
TEST_F(Visibility, DoesNotDependOnTheDrawingOrder) {
  const RenderInstance far{square_, Translation({0, 0, 0.5}), 1};
  const RenderInstance near{square_, Translation({-0.05, 0, 0.4999}), 2};
  const auto a = Fractions({far, near}), b = Fractions({near, far});
  EXPECT_EQ(a[0], b[1]);
  EXPECT_EQ(a[1], b[0]);
  EXPECT_NEAR(a[0], 0.5, 0.01);
}

TEST_F(Visibility, PixelsOutsideTheImageCountAsHidden) {
  // The image ends 110 px to the right of and below its center.
  EXPECT_NEAR(Fractions({{square_, Translation({0.11, 0, 0.5}), 1}})[0], 0.5, 0.01);
  EXPECT_NEAR(Fractions({{square_, Translation({0.11, 0.11, 0.5}), 1}})[0], 0.25, 0.01);
}

TEST_F(Visibility, HiddenOrOutsideIsZero) {
  const auto fractions = Fractions({{square_, Translation({0, 0, 0.5}), 1},
                                    {square_, Translation({0, 0, 0.4}), 2},
                                    {square_, Translation({0.5, 0, 0.5}), 3},
                                    {square_, Translation({0, 0, -0.5}), 4}});
  EXPECT_EQ(fractions, (std::vector{0.0, 1.0, 0.0, 0.0}));
}

// A thin box and the square at random poses, each as the only instance in a large image.
TEST_F(Visibility, SingleInstanceHasFractionOne) {
  Rng rng(2);
  const int box = renderer_.AddMesh(BoxMesh({0.2, 0.01, 0.03}));
  camera_ = TestCamera(1200, 1000, 900);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), 0.5);
    const Pose X = MakePose(rng.Rotation().toRotationMatrix(), p);
    EXPECT_NEAR(Fractions({{i % 2 ? box : square_, X, 9}})[0], 1.0, 2e-3);
  }
}

TEST(SceneRenderer, IdsAndFractionsAreAssignedToInstances) {
  auto cube = std::make_shared<ObjectModel>();
  cube->mesh_O = BoxMesh({0.06, 0.06, 0.06});
  auto plate = std::make_shared<ObjectModel>();
  plate->mesh_O = BoxMesh({0.1, 0.1, 0.01});
  Scene scene;
  // The plate rests on the first cube and hides half of it, seen from straight above.
  scene.objects = {{InstanceId{4}, ObjectId{0}, Translation({0.1, 0, 0.03})},
                   {InstanceId{2}, ObjectId{1}, Translation({0.15, 0, 0.065})},
                   {InstanceId{7}, ObjectId{0}, Translation({-0.1, 0, 0.03})}};
  SceneRenderer renderer({cube, plate}, scene.bin);
  Camera camera;
  camera.SetPose(LookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}));
  camera.intrinsics = {640, 480, 4000, 4000, 319.5, 239.5};
  const RenderedImage image = renderer.Render(scene, camera);
  std::vector<int> ids(image.ids.pixels().begin(), image.ids.pixels().end());
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  EXPECT_EQ(ids, (std::vector{0, 3, 5, 8}));
  const auto fractions = renderer.VisibleFractions(scene, camera, image.ids);
  EXPECT_NEAR(fractions[0], 0.5, 0.03);  // perspective shows a small part of its sides
  EXPECT_NEAR(fractions[1], 1.0, 1e-9);
  EXPECT_NEAR(fractions[2], 1.0, 1e-9);
  // The bin's floor is at z = 0: 5 m from the camera.
  EXPECT_NEAR(image.depth_m(320, 240), 5.0, 1e-5);
}

}  // namespace
}  // namespace pickbed::tests
