#include "sim/render/renderer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scenes/base/error.h"
#include "scenes/base/random.h"
#include "tests/sim/render_support.h"
#include "tests/support/tapered_bin.h"

namespace pickbed::tests {
namespace {

constexpr double kDepthTolerance_m = 2e-5;
const Light kWhiteAmbient{{0, 0, 0}, 1.0, 0.0};

std::vector<RenderInstance> One(int mesh, const Pose& X_WO, uint16_t id = 1) {
  return {{mesh, X_WO, id}};
}

int CountId(const RenderedImage& image, uint16_t id) {
  return static_cast<int>(std::count(image.ids.pixels().begin(), image.ids.pixels().end(), id));
}

TEST(Renderer, TiltedPlaneDepthMatchesTheFormula) {
  Renderer renderer;
  const int mesh = renderer.AddMesh(RectangleMesh(-3, -3, 3, 3));
  Camera camera = TestCamera(160, 120, 150);
  camera.intrinsics = {160, 120, 140, 150, 70.25, 66.5};
  const Pose X_CO = Translation({0.1, -0.05, 0.9}) *
                    Pose(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 0.5, 0.2).normalized()));
  const Eigen::Vector3d n = X_CO.linear().col(2);
  for (const bool color : {true, false}) {
    const auto instances = One(mesh, X_CO, 7);
    const RenderedImage image =
        color ? renderer.Render(camera, instances) : renderer.RenderDepth(camera, instances);
    EXPECT_EQ(image.color.empty(), !color);
    double worst_m = 0;
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 160; ++u) {
        // The ray of (u, v) meets the plane n.p = n.X_CO.translation().
        const double expected =
            n.dot(X_CO.translation()) / n.dot(BackProject(camera.intrinsics, u, v, 1.0));
        worst_m = std::max(worst_m, std::abs(image.depth_m(u, v) - expected));
        ASSERT_EQ(image.ids(u, v), 7);
      }
    }
    RecordProperty(color ? "worst_um" : "worst_depth_only_um", std::to_string(1e6 * worst_m));
    EXPECT_LT(worst_m, kDepthTolerance_m);
  }
}

TEST(Renderer, SphereDepthAndOutlineMatchTheFormula) {
  constexpr double kRadius_m = 0.1;
  Renderer renderer({}, kOriginal);
  const int mesh = renderer.AddMesh(SphereMesh(kRadius_m, 5));
  Camera camera = TestCamera(200, 150, 260);
  camera.SetPose(LookAt({0.4, -0.3, 0.6}, {0.05, 0, 0.02}, {0, 0, 1}));
  const Eigen::Vector3d center_W(0.02, 0.03, -0.01);
  const RenderedImage image = renderer.Render(camera, One(mesh, Translation(center_W)));
  const Eigen::Vector3d c = camera.X_CW() * center_W;
  // Faces of the mesh are inside the sphere by up to 30 um.
  constexpr double kInside_m = 4e-5;
  int wrong_outline = 0, covered = 0;
  for (int v = 0; v < 150; ++v) {
    for (int u = 0; u < 200; ++u) {
      const Eigen::Vector3d ray = BackProject(camera.intrinsics, u, v, 1.0);
      const double a = ray.squaredNorm(), b = ray.dot(c);
      const double d = b * b - a * (c.squaredNorm() - kRadius_m * kRadius_m);
      covered += d > 0;
      wrong_outline += (d > 0) != (image.depth_m(u, v) > 0);
      if (d <= 0) continue;
      const double z = (b - std::sqrt(d)) / a;
      const double cosine = -ray.normalized().dot((z * ray - c) / kRadius_m);
      if (cosine > 0.5) {
        EXPECT_NEAR(image.depth_m(u, v), z, kInside_m / cosine) << u << " " << v;
      }
    }
  }
  EXPECT_GT(covered, 2000);
  EXPECT_LE(wrong_outline, covered / 500);
}

// The edges of the rectangle are between pixel centers, so it covers exactly those pixels. A shift
// by half a pixel, a flipped row order or exchanged axes fail here.
TEST(Renderer, RectangleCoversExactlyItsPixels) {
  Renderer renderer;
  Camera camera = TestCamera(64, 48, 100);
  camera.intrinsics = {64, 48, 100, 100, 30, 20};
  const double z = 0.5, m_per_px = z / 100;
  // u from 9.5 to 19.5, v from 4.6 to 9.4.
  const int mesh = renderer.AddMesh(RectangleMesh((9.6 - 30) * m_per_px, (4.6 - 20) * m_per_px,
                                                  (19.4 - 30) * m_per_px, (9.4 - 20) * m_per_px));
  const RenderedImage image = renderer.Render(camera, One(mesh, Translation({0, 0, z}), 3));
  for (int v = 0; v < 48; ++v) {
    for (int u = 0; u < 64; ++u) {
      const bool inside = u >= 10 && u <= 19 && v >= 5 && v <= 9;
      EXPECT_EQ(image.ids(u, v), inside ? 3 : 0) << u << " " << v;
      EXPECT_EQ(image.depth_m(u, v) > 0, inside);
    }
  }
}

TEST(Renderer, EmptySceneIsAllZero) {
  Renderer renderer;
  const RenderedImage image = renderer.Render(TestCamera(33, 17, 50), {});
  EXPECT_EQ(image.depth_m, Image<float>(33, 17));
  EXPECT_EQ(image.ids, Image<uint16_t>(33, 17));
  EXPECT_EQ(image.color, Image<Rgb8>(33, 17));
}

TEST(Renderer, OpenMeshShowsBothSides) {
  Renderer renderer;
  const int mesh = renderer.AddMesh(RectangleMesh(-0.1, -0.1, 0.1, 0.1));
  const Camera camera = TestCamera(40, 40, 50);
  const Pose rotated = Translation({0, 0, 0.3}) *
                       Pose(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const RenderedImage front = renderer.Render(camera, One(mesh, Translation({0, 0, 0.3})));
  const RenderedImage back = renderer.Render(camera, One(mesh, rotated));
  EXPECT_GT(CountId(front, 1), 900);
  EXPECT_EQ(front.ids, back.ids);
}

// A box without one face is open and is drawn without culling; seen from the other side it must
// look the same. An inside-out box must not be culled either.
TEST(Renderer, CullingOfClosedMeshesChangesNothing) {
  Renderer renderer;
  const TriangleMesh closed = BoxMesh({0.1, 0.12, 0.08});
  TriangleMesh open = closed, inside_out = closed;
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);  // z+ in O
  for (auto& t : inside_out.triangles) std::swap(t[1], t[2]);
  const Camera camera = TestCamera(80, 60, 100);
  const Pose X_CO = Translation({0.01, 0, 0.4}) *
                    Pose(Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 1, 0).normalized()));
  const RenderedImage reference = renderer.Render(camera, One(renderer.AddMesh(closed), X_CO));
  EXPECT_GT(CountId(reference, 1), 500);
  for (const TriangleMesh& other : {open, inside_out}) {
    const RenderedImage image = renderer.Render(camera, One(renderer.AddMesh(other), X_CO));
    EXPECT_EQ(reference.ids, image.ids);
    for (size_t i = 0; i < image.depth_m.size(); ++i) {
      ASSERT_NEAR(reference.depth_m.data()[i], image.depth_m.data()[i], 5e-6);
    }
  }
}

TEST(Renderer, TextureIsUprightAndNotReflected) {
  TriangleMesh mesh = RectangleMesh(-0.1, -0.1, 0.1, 0.1);
  const Rgb8 red{255, 0, 0}, green{0, 255, 0}, blue{0, 0, 255}, white{255, 255, 255};
  constexpr int kSide = 32;
  mesh.texture = Image<Rgb8>(kSide, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const bool left = x < kSide / 2, top = y < kSide / 2;
      mesh.texture(x, y) = top ? (left ? red : green) : (left ? blue : white);
    }
  }
  Renderer renderer;
  const RenderedImage image = renderer.Render(
      TestCamera(64, 64, 64), One(renderer.AddMesh(mesh), Translation({0, 0, 0.3})), kWhiteAmbient);
  EXPECT_EQ(image.color(20, 20), red);
  EXPECT_EQ(image.color(43, 20), green);
  EXPECT_EQ(image.color(20, 43), blue);
  EXPECT_EQ(image.color(43, 43), white);
}

TEST(Renderer, VertexAndBaseColorsAreDrawn) {
  TriangleMesh mesh = RectangleMesh(-0.1, -0.1, 0.1, 0.1);
  mesh.base_color = {10, 200, 90};
  Renderer renderer;
  const Camera camera = TestCamera(65, 65, 64);
  const Pose X_CO = Translation({0, 0, 0.2});
  EXPECT_EQ(renderer.Render(camera, One(renderer.AddMesh(mesh), X_CO), kWhiteAmbient).color(32, 32),
            (Rgb8{10, 200, 90}));
  // Red is 0 on the left and 200 on the right, so it is 100 in the center.
  mesh.colors = {{0, 0, 0}, {200, 0, 0}, {200, 0, 0}, {0, 0, 0}};
  const RenderedImage image =
      renderer.Render(camera, One(renderer.AddMesh(mesh), X_CO), kWhiteAmbient);
  EXPECT_NEAR(image.color(32, 32).r, 100, 1);
  EXPECT_NEAR(image.color(16, 32).r, 50, 1);
}

// Lambert's law, with normals from vertices and from faces.
TEST(Renderer, ShadingFollowsTheCosineOfThePointLight) {
  TriangleMesh mesh = RectangleMesh(-1, -1, 1, 1);
  mesh.base_color = {200, 200, 200};
  Renderer renderer;
  const int flat = renderer.AddMesh(mesh);
  mesh.normals.assign(4, -Eigen::Vector3d::UnitZ());
  const int smooth = renderer.AddMesh(mesh);
  const Camera camera = TestCamera(81, 61, 60);
  const Light light{{0.3, 0, 0}, 0.25, 0.5};
  for (const int handle : {flat, smooth}) {
    const RenderedImage image =
        renderer.Render(camera, One(handle, Translation({0, 0, 0.6})), light);
    for (const int u : {5, 40, 70, 75}) {
      const Eigen::Vector3d p = BackProject(camera.intrinsics, u, 30, 0.6);
      const double cosine = 0.6 / (light.position_W - p).norm();
      EXPECT_NEAR(image.color(u, 30).g, 200 * (0.25 + 0.5 * cosine), 1.01) << u;
    }
  }
}

TEST(Renderer, MeshesBehindTheCameraAreClipped) {
  Renderer renderer;
  const int box = renderer.AddMesh(BoxMesh({0.2, 0.2, 2}));
  const Camera camera = TestCamera(60, 60, 60);
  EXPECT_EQ(CountId(renderer.Render(camera, One(box, Translation({0, 0, -2}))), 1), 0);
  const RenderedImage image = renderer.Render(camera, One(box, Translation({0.2, 0, 0})));
  EXPECT_GT(CountId(image, 1), 100);  // the box's left face, beside the camera
  for (size_t i = 0; i < image.depth_m.size(); ++i) {
    if (image.ids.data()[i]) {
      EXPECT_GE(image.depth_m.data()[i], 0.0049);
      EXPECT_LE(image.depth_m.data()[i], 1.0001);
    }
  }
}

struct Views {
  std::vector<Camera> cameras;
  std::vector<RenderInstance> instances;
};

// Objects inside, across the border of and outside their images, of two meshes and two image sizes.
Views MixedViews(int box, int sphere) {
  Views views;
  Rng rng(5);
  for (int i = 0; i < 60; ++i) {
    const int side = i % 7 == 0 ? 48 : 32;
    Camera camera = TestCamera(side, i % 7 == 0 ? 40 : 32, 60);
    camera.SetPose(MakePose(rng.Rotation().toRotationMatrix(), {0.3, 0.1, -0.2}));
    const Eigen::Vector3d p_C(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2), 0.4);
    const Pose X_WO = camera.X_WC() * MakePose(rng.Rotation().toRotationMatrix(), p_C);
    views.cameras.push_back(camera);
    views.instances.push_back({i % 3 ? box : sphere, X_WO, static_cast<uint16_t>(i + 1)});
  }
  return views;
}

TEST(Renderer, BatchOfViewsEqualsSingleRenders) {
  Renderer renderer;
  const Views views = MixedViews(renderer.AddMesh(BoxMesh({0.1, 0.05, 0.08})),
                                 renderer.AddMesh(SphereMesh(0.06, 3)));
  const auto many = renderer.RenderEach(views.cameras, views.instances);
  const auto depth_only = renderer.RenderEachDepth(views.cameras, views.instances);
  const auto counts = renderer.CountEach(views.cameras, views.instances);
  int different = 0, total = 0;
  for (size_t i = 0; i < many.size(); ++i) {
    const RenderedImage one = renderer.Render(views.cameras[i], std::vector{views.instances[i]});
    ASSERT_EQ(one.depth_m.width(), many[i].depth_m.width());
    ASSERT_EQ(one.depth_m.height(), many[i].depth_m.height());
    EXPECT_TRUE(depth_only[i].color.empty());
    EXPECT_EQ(depth_only[i].depth_m, many[i].depth_m);
    EXPECT_EQ(depth_only[i].ids, many[i].ids);
    EXPECT_EQ(counts[i], CountId(many[i], views.instances[i].id));
    for (size_t p = 0; p < one.depth_m.size(); ++p) {
      ++total;
      if (one.ids.data()[p] != many[i].ids.data()[p]) {
        ++different;  // an outline pixel with a different rounding
        continue;
      }
      // Rounding by 1e-4 px has a visible effect only where a face is seen edge-on.
      const double off_m = std::abs(one.depth_m.data()[p] - many[i].depth_m.data()[p]);
      different += off_m > 5e-6;
      ASSERT_LT(off_m, 1e-4);
      ASSERT_NEAR(one.color.data()[p].g, many[i].color.data()[p].g, 1);
    }
  }
  EXPECT_LT(different, total / 5000);
}

TEST(Renderer, SameCallGivesSameBytes) {
  Renderer renderer, other;
  RenderedImage images[3];
  for (int i = 0; i < 3; ++i) {
    Renderer& r = i == 2 ? other : renderer;
    const int sphere = r.AddMesh(SphereMesh(0.06, 3));
    images[i] = r.Render(TestCamera(90, 70, 80), One(sphere, Translation({0.01, 0, 0.3})));
    r.Render(TestCamera(20, 20, 30), One(sphere, Translation({0.01, 0, 0.2})));
  }
  for (int i = 1; i < 3; ++i) {
    EXPECT_EQ(images[0].color, images[i].color);
    EXPECT_EQ(images[0].depth_m, images[i].depth_m);
    EXPECT_EQ(images[0].ids, images[i].ids);
  }
}

TEST(Renderer, LevelsOfDetailStayWithinTheirDeviation) {
  constexpr double kDeviation_m = 1e-3;
  const TriangleMesh sphere = SphereMesh(0.05, 4);
  Renderer fine({}, kOriginal), coarse({}, {kDeviation_m, 0});
  const int fine_mesh = fine.AddMesh(sphere), coarse_mesh = coarse.AddMesh(sphere);
  const Camera camera = TestCamera(121, 121, 300);
  const RenderedImage a = fine.Render(camera, One(fine_mesh, Translation({0, 0, 0.4})));
  const RenderedImage b = coarse.Render(camera, One(coarse_mesh, Translation({0, 0, 0.4})));
  int both = 0, either = 0, equal_depth = 0;
  for (int v = 0; v < 121; ++v) {
    for (int u = 0; u < 121; ++u) {
      const float za = a.depth_m(u, v), zb = b.depth_m(u, v);
      either += za > 0 || zb > 0;
      both += za > 0 && zb > 0;
      equal_depth += za > 0 && za == zb;
      // Within 28 of the 38 pixels of the radius, the cosine between ray and normal is above 0.6.
      if (std::hypot(u - 60, v - 60) < 28) {
        ASSERT_NEAR(za, zb, kDeviation_m / 0.6);
      }
    }
  }
  EXPECT_GT(both, 0.95 * either);
  EXPECT_LT(equal_depth, both / 10);  // a coarser mesh was used
}

// A mesh bin has the same inner size and walls as the box that other tests use in its place.
TEST(SceneRenderer, BinsWithTheSameSizeAndOtherShapeDiffer) {
  const auto shape = std::make_shared<BinShape>(MakeBinShape(TaperedBin(), "bin"));
  Scene box;
  box.bin.inner_size_m = shape->inner_size_m;
  box.bin.wall_m = shape->wall_m;
  Scene tapered = box;
  tapered.bin.shape = shape;
  Camera camera = TestCamera(160, 120, 150);
  camera.SetPose(LookAt({0, 0.1, 0.6}, {0, 0, 0}, Eigen::Vector3d::UnitZ()));
  SceneRenderer renderer({}, box.bin);
  EXPECT_NE(renderer.Render(box, camera).depth_m, renderer.Render(tapered, camera).depth_m);
}

TEST(Renderer, InvalidInputIsRefused) {
  Renderer renderer;
  const int box = renderer.AddMesh(BoxMesh({0.1, 0.1, 0.1}));
  const Views views = MixedViews(box, box);
  try {
    renderer.Render(TestCamera(0, 480, 600), {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("width = 0"));
  }
  EXPECT_THROW(renderer.RenderEach(views.cameras, One(box, Pose::Identity())), InputError);
  EXPECT_THROW(renderer.Render(TestCamera(8, 8, 8), One(box + 1, Pose::Identity())),
               std::out_of_range);
}

}  // namespace
}  // namespace pickbed::tests
