// Tests the optional outputs of a draw pass, and what must not change an image.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/base/random.h"
#include "scenes/part_families/part_families.h"
#include "sim/render/renderer.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

constexpr RenderOutputs kAllOutputs{true, true, true, true};

void ExpectSameBytes(const RenderedImage& a, const RenderedImage& b) {
  EXPECT_EQ(a.color, b.color);
  EXPECT_EQ(a.depth_m, b.depth_m);
  EXPECT_EQ(a.ids, b.ids);
  EXPECT_EQ(a.normals_C, b.normals_C);
  EXPECT_EQ(a.coordinates_O, b.coordinates_O);
}

// Spheres, boxes and a bracket that intersect each other, seen by a tilted camera.
struct IntersectingMeshes {
  explicit IntersectingMeshes(Renderer& renderer) {
    const int meshes[] = {renderer.AddMesh(BoxMesh({0.12, 0.08, 0.05})),
                          renderer.AddMesh(SphereMesh(0.05, 3)),
                          renderer.AddMesh(FamilyTable().front().make().mesh_O)};
    camera = TestCamera(160, 120, 170);
    camera.SetPose(LookAt({0.1, -0.4, 0.5}, {0, 0, 0}, {0, 0, 1}));
    Rng rng(11);
    for (int i = 0; i < 12; ++i) {
      const Eigen::Vector3d p(rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(0, 0.1));
      instances.push_back({meshes[i % 3], MakePose(rng.Rotation().toRotationMatrix(), p),
                           static_cast<uint16_t>(i + 1)});
    }
  }
  Camera camera;
  std::vector<RenderInstance> instances;
};

TEST(RenderOutputs, OutputsNotRequestedAreEmpty) {
  Renderer renderer({}, {}, PlainSurfaces::kOpenGl);
  const IntersectingMeshes scene(renderer);
  const RenderedImage all = renderer.Render(scene.camera, scene.instances, {}, kAllOutputs);
  const RenderedImage default_image = renderer.Render(scene.camera, scene.instances);
  EXPECT_TRUE(default_image.normals_C.empty());
  EXPECT_TRUE(default_image.coordinates_O.empty());
  EXPECT_EQ(default_image.depth_m, all.depth_m);
  EXPECT_EQ(default_image.ids, all.ids);
  size_t close = 0;
  for (size_t i = 0; i < all.color.size(); ++i) {
    close += std::abs(all.color.data()[i].g - default_image.color.data()[i].g) <= 1;
  }
  EXPECT_EQ(close, all.color.size());
  const RenderedImage bare =
      renderer.Render(scene.camera, scene.instances, {}, {false, false, false, false});
  EXPECT_TRUE(bare.color.empty());
  EXPECT_TRUE(bare.ids.empty());
  ASSERT_EQ(bare.depth_m.size(), default_image.depth_m.size());
  for (size_t i = 0; i < bare.depth_m.size(); ++i) {
    ASSERT_NEAR(bare.depth_m.data()[i], default_image.depth_m.data()[i], 1e-6);
  }
}

TEST(RenderOutputs, SphereNormalsAreItsRadii) {
  constexpr double kRadius_m = 0.1;
  TriangleMesh sphere = SphereMesh(kRadius_m, 5);
  for (const Eigen::Vector3d& v : sphere.vertices) sphere.normals.push_back(v.normalized());
  Renderer renderer({}, kOriginal);
  const Pose X_CO = Translation({0.03, -0.02, 0.5});
  const Camera camera = TestCamera(120, 100, 200);
  const RenderedImage image = renderer.Render(
      camera, std::vector{RenderInstance{renderer.AddMesh(sphere), X_CO, 1}}, {}, kAllOutputs);
  int seen = 0;
  for (int v = 0; v < 100; ++v) {
    for (int u = 0; u < 120; ++u) {
      const Eigen::Vector3f n = image.normals_C(u, v);
      if (image.depth_m(u, v) == 0) {
        EXPECT_EQ(n, Eigen::Vector3f::Zero());
        continue;
      }
      ++seen;
      const Eigen::Vector3d p_C = BackProject(camera.intrinsics, u, v, image.depth_m(u, v));
      const Eigen::Vector3d radius = (p_C - X_CO.translation()).normalized();
      ASSERT_NEAR(n.norm(), 1, 1e-5);
      if (radius.dot(p_C.normalized()) > -0.3) continue;  // a face seen edge-on spans many degrees
      ASSERT_GT(n.cast<double>().dot(radius), std::cos(0.01)) << u << " " << v;
    }
  }
  EXPECT_GT(seen, 3000);
}

// A mesh without normals has face normals, which point towards the camera on both sides.
TEST(RenderOutputs, PlaneNormalsFaceTheCamera) {
  Renderer renderer;
  const int mesh = renderer.AddMesh(RectangleMesh(-1, -1, 1, 1));
  for (const double angle : {0.5, 0.5 + std::numbers::pi}) {
    const Pose X_CO = Translation({0, 0, 0.6}) *
                      Pose(Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 0.5, 0).normalized()));
    const RenderedImage image = renderer.Render(
        TestCamera(60, 50, 80), std::vector{RenderInstance{mesh, X_CO, 1}}, {}, kAllOutputs);
    Eigen::Vector3d expected = X_CO.linear().col(2);
    if (expected.z() > 0) expected = -expected;
    ASSERT_FALSE(image.normals_C.empty());
    for (const Eigen::Vector3f& n : image.normals_C.pixels()) {
      ASSERT_LT((n.cast<double>() - expected).norm(), 1e-3);
    }
  }
}

TEST(RenderOutputs, CoordinatesAreTheDepthInObjectFrame) {
  Renderer renderer;
  const IntersectingMeshes scene(renderer);
  const RenderedImage image = renderer.Render(scene.camera, scene.instances, {}, kAllOutputs);
  double worst_m = 0;
  int seen = 0;
  for (int v = 0; v < image.ids.height(); ++v) {
    for (int u = 0; u < image.ids.width(); ++u) {
      if (image.ids(u, v) == 0) continue;
      const Pose X_OC = scene.instances[image.ids(u, v) - 1].X_WO.inverse() * scene.camera.X_WC();
      const Eigen::Vector3d p_O =
          X_OC * BackProject(scene.camera.intrinsics, u, v, image.depth_m(u, v));
      worst_m = std::max(worst_m, (p_O - image.coordinates_O(u, v).cast<double>()).norm());
      ++seen;
    }
  }
  EXPECT_GT(seen, 3000);
  EXPECT_LT(worst_m, 1e-5);
}

TEST(RenderOutputs, InstancesOutOfViewChangeNothing) {
  Renderer renderer;
  IntersectingMeshes scene(renderer);
  const RenderedImage before = renderer.Render(scene.camera, scene.instances, {}, kAllOutputs);
  const int mesh = scene.instances[0].mesh;
  for (const Eigen::Vector3d& p_C : {Eigen::Vector3d(0, 0, -0.5), Eigen::Vector3d(2, 0, 0.5),
                                     Eigen::Vector3d(0, -2, 0.3), Eigen::Vector3d(-3, 2, 1)}) {
    scene.instances.insert(scene.instances.begin(),
                           {mesh, scene.camera.X_WC() * Translation(p_C), 99});
  }
  ExpectSameBytes(before, renderer.Render(scene.camera, scene.instances, {}, kAllOutputs));
}

// Only the rectangle around the visible meshes is drawn. Its pixels must equal the pixels of an
// image that is drawn completely.
TEST(RenderOutputs, PixelsDoNotDependOnTheDrawnRectangle) {
  Renderer renderer;
  const int sphere = renderer.AddMesh(SphereMesh(0.03, 3));
  const int wall = renderer.AddMesh(RectangleMesh(-9, -9, 9, 9));
  const Camera camera = TestCamera(300, 220, 300);
  Rng rng(3);
  for (int i = 0; i < 12; ++i) {
    const Pose X = Translation({rng.Uniform(-0.5, 0.5), rng.Uniform(-0.4, 0.4), 0.9});
    const RenderedImage cropped =
        renderer.Render(camera, std::vector{RenderInstance{sphere, X, 5}}, {}, kAllOutputs);
    const RenderedImage whole = renderer.Render(
        camera,
        std::vector{RenderInstance{sphere, X, 5}, RenderInstance{wall, Translation({0, 0, 2}), 0}},
        {}, kAllOutputs);
    int different = 0, seen = 0;
    for (size_t p = 0; p < cropped.ids.size(); ++p) {
      different += cropped.ids.data()[p] != whole.ids.data()[p];
      if (cropped.ids.data()[p] == 0) {
        EXPECT_EQ(cropped.depth_m.data()[p], 0);
        EXPECT_EQ(cropped.color.data()[p], Rgb8());
        continue;
      }
      ++seen;
      different += std::abs(cropped.depth_m.data()[p] - whole.depth_m.data()[p]) > 2e-6;
      different += std::abs(cropped.color.data()[p].r - whole.color.data()[p].r) > 1;
    }
    EXPECT_LE(different, 1) << i;
    if (std::abs(X.translation().x()) < 0.4 && std::abs(X.translation().y()) < 0.28) {
      EXPECT_GT(seen, 250);
    }
  }
}

TEST(RenderOutputs, SeveralCamerasEqualSingleRenders) {
  Renderer renderer;
  const IntersectingMeshes scene(renderer);
  std::vector<Camera> cameras = {scene.camera, scene.camera, TestCamera(70, 90, 60)};
  cameras[1].SetPose(LookAt({-0.3, 0.2, 0.4}, {0, 0, 0}, {0, 0, 1}));
  cameras[2].SetPose(LookAt({0, 0, 0.7}, {0, 0, 0}, {0, 1, 0}));
  const Light light{{0.2, 0.1, 1.0}, 0.3, 0.7, true};
  const auto images = renderer.RenderCameras(cameras, scene.instances, light, kAllOutputs);
  ASSERT_EQ(images.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    ExpectSameBytes(images[i], renderer.Render(cameras[i], scene.instances, light, kAllOutputs));
  }
  EXPECT_NE(images[0].depth_m, images[1].depth_m);
}

// A floor 1 m in front of a lamp, with a square half way: the shadow has twice the side of the
// square.
class Shadow : public testing::Test {
 protected:
  Shadow() : camera_(TestCamera(201, 201, 250)) {
    TriangleMesh floor = RectangleMesh(-0.5, -0.5, 0.5, 0.5);
    floor.base_color = {200, 200, 200};
    const int floor_mesh = renderer_.AddMesh(floor);
    const int square = renderer_.AddMesh(RectangleMesh(-0.04, -0.04, 0.04, 0.04));
    // The lamp is 0.3 m beside the camera.
    light_ = {{0.3, 0, 0}, 0.25, 0.75, true, 0.001};
    instances_ = {{floor_mesh, Translation({0, 0, 1}), 1},
                  {square, Translation({0.2, 0.1, 0.5}), 2}};
  }

  // Returns the expected grey level of a lit floor point.
  double ExpectedGrey(const Eigen::Vector3d& p) const {
    return 200 * (0.25 + 0.75 / (light_.position_W - p).norm());
  }
  // Returns how far a floor point is inside the outline of the shadow, in metres; negative outside.
  static double InsideShadow_m(const Eigen::Vector3d& p) {
    const Eigen::Vector2d center(2 * 0.2 - 0.3, 2 * 0.1);
    return 0.08 - (p.head<2>() - center).cwiseAbs().maxCoeff();
  }

  Renderer renderer_;
  Camera camera_;
  Light light_;
  std::vector<RenderInstance> instances_;
};

TEST_F(Shadow, HasTheGeometricOutline) {
  const RenderedImage image = renderer_.Render(camera_, instances_, light_);
  // Three texels of the shadow map, which are large for a near lamp.
  constexpr double kEdge_m = 0.015;
  int in_shadow = 0, lit = 0;
  for (int v = 0; v < 201; ++v) {
    for (int u = 0; u < 201; ++u) {
      if (image.ids(u, v) != 1) continue;
      const Eigen::Vector3d p = BackProject(camera_.intrinsics, u, v, 1.0);
      const double inside_m = InsideShadow_m(p);
      if (inside_m > kEdge_m) {
        ++in_shadow;
        ASSERT_NEAR(image.color(u, v).g, 200 * 0.25, 1) << u << " " << v;
      } else if (inside_m < -kEdge_m) {
        ++lit;
        ASSERT_NEAR(image.color(u, v).g, ExpectedGrey(p), 1.5) << u << " " << v;
      }
    }
  }
  EXPECT_GT(in_shadow, 500);
  EXPECT_GT(lit, 10000);
}

TEST_F(Shadow, IsSofterOnRequestAndCanBeOff) {
  const auto half_lit = [&](const Light& light) {
    const RenderedImage image = renderer_.Render(camera_, instances_, light);
    int count = 0;
    for (int v = 0; v < 201; ++v) {
      for (int u = 0; u < 201; ++u) {
        if (image.ids(u, v) != 1) continue;
        const Eigen::Vector3d p = BackProject(camera_.intrinsics, u, v, 1.0);
        const double grey = image.color(u, v).g;
        count += grey > 200 * 0.25 + 3 && grey < ExpectedGrey(p) - 3;
      }
    }
    return count;
  };
  Light off = light_, soft = light_;
  off.shadow = false;
  soft.shadow_softness_m = 0.03;
  EXPECT_EQ(half_lit(off), 0);
  EXPECT_GT(half_lit(light_), 0);
  EXPECT_GT(half_lit(soft), 2 * half_lit(light_));
}

// A single closed object casts no shadow on its lit side: the coarse depth of the shadow map causes
// no spots.
TEST_F(Shadow, LitSidesHaveNoShadowSpots) {
  const int sphere = renderer_.AddMesh(SphereMesh(0.1, 5));
  const std::vector<RenderInstance> one{{sphere, Translation({0, 0, 0.6}), 1}};
  Light dark = light_;
  dark.shadow = false;
  const RenderedImage with = renderer_.Render(camera_, one, light_);
  const RenderedImage without = renderer_.Render(camera_, one, dark);
  for (size_t i = 0; i < with.color.size(); ++i) {
    ASSERT_NEAR(with.color.data()[i].g, without.color.data()[i].g, 12);
  }
}

TEST(Materials, TintGlossAndGrainHaveTheirEffect) {
  Renderer renderer;
  TriangleMesh plane = RectangleMesh(-1, -1, 1, 1);
  plane.base_color = {200, 100, 40};
  RenderInstance instance{renderer.AddMesh(plane), Translation({0, 0, 0.5}), 1};
  const Camera camera = TestCamera(81, 81, 100);
  const Light ambient{{0, 0, 0}, 1, 0}, lamp{{0, 0, 0}, 0.2, 0.5};
  const auto draw = [&](const Light& light) {
    return renderer.Render(camera, std::vector{instance}, light).color;
  };
  const Image<Rgb8> plain = draw(lamp);
  instance.material.tint = {0.5, 1, 0.25};
  EXPECT_EQ(draw(ambient)(40, 40), (Rgb8{100, 100, 10}));
  instance.material = {};
  // The lamp is at the camera, so its reflection is in the center, where it adds diffuse times
  // gloss.
  instance.material.gloss = 0.4;
  EXPECT_NEAR(draw(lamp)(40, 40).g - plain(40, 40).g, 255 * 0.5 * 0.4, 1);
  EXPECT_LT(draw(lamp)(0, 0).g - plain(0, 0).g, 20);
  instance.material = {};
  instance.material.grain = 0.5;
  const Image<Rgb8> grain = draw(ambient);
  int min_level = 255, max_level = 0;
  for (const Rgb8& c : grain.pixels()) {
    min_level = std::min<int>(min_level, c.r);
    max_level = std::max<int>(max_level, c.r);
  }
  EXPECT_GE(min_level, 99);
  EXPECT_LT(min_level, 125);
  EXPECT_GT(max_level, 175);
  EXPECT_LE(max_level, 200);
  EXPECT_EQ(grain, draw(ambient));
}

}  // namespace
}  // namespace pickbed::tests
