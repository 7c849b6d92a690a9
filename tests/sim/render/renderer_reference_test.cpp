// Compares the renderer with independent references: ray casting, images of another program, and
// the two kinds of OpenGL context.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "scenes/bin/bin.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/image/image_io.h"
#include "scenes/mesh_io/mesh_io.h"
#include "scenes/part_families/part_families.h"
#include "sim/render/renderer.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

struct RayResult {
  uint16_t id = 0;
  double depth_m = 0;
};

// Returns the nearest instance along the ray of pixel (u, v).
RayResult CastRay(const std::vector<MeshQuery>& queries, const Camera& camera,
                  const std::vector<RenderInstance>& instances, double u, double v) {
  const Eigen::Vector3d ray_C = BackProject(camera.intrinsics, u, v, 1.0);
  RayResult best;
  for (size_t i = 0; i < instances.size(); ++i) {
    const Pose X_OC = instances[i].X_WO.inverse() * camera.X_WC();
    const auto hit = queries[instances[i].mesh].Raycast(
        X_OC.translation(), X_OC.linear() * ray_C.normalized(), 1e-6, 100);
    if (!hit) continue;
    const double depth_m = hit->distance / ray_C.norm();
    if (best.id == 0 || depth_m < best.depth_m) best = {instances[i].id, depth_m};
  }
  return best;
}

class RayCasting : public testing::TestWithParam<PlainSurfaces> {};

TEST_P(RayCasting, MatchesIdsAndDepth) {
  const std::vector<TriangleMesh> meshes = {BoxMesh({0.12, 0.08, 0.05}), SphereMesh(0.05, 3),
                                            FamilyTable().front().make().mesh_O};
  Renderer renderer({}, kOriginal, GetParam());
  std::vector<MeshQuery> queries;
  for (const TriangleMesh& mesh : meshes) {
    renderer.AddMesh(mesh);
    queries.emplace_back(mesh);
  }
  Camera camera = TestCamera(160, 120, 170);
  camera.SetPose(LookAt({0.1, -0.4, 0.5}, {0, 0, 0}, {0, 0, 1}));
  Rng rng(11);
  std::vector<RenderInstance> instances;  // many of them intersect each other
  for (int i = 0; i < 18; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.15, 0.15), rng.Uniform(0, 0.1));
    instances.push_back(
        {i % 3, MakePose(rng.Rotation().toRotationMatrix(), p), static_cast<uint16_t>(i + 1)});
  }
  const RenderedImage image = renderer.Render(camera, instances);
  int on_borders = 0, covered = 0;
  double worst_m = 0;
  for (int v = 0; v < image.ids.height(); ++v) {
    for (int u = 0; u < image.ids.width(); ++u) {
      const RayResult expected = CastRay(queries, camera, instances, u, v);
      covered += expected.id != 0;
      if (image.ids(u, v) == expected.id) {
        worst_m = std::max(worst_m, std::abs(image.depth_m(u, v) - expected.depth_m));
        continue;
      }
      // OpenGL rounds outlines to 1/256 of a pixel, so a ray beside the pixel center must hit the
      // drawn instance.
      ++on_borders;
      bool explained = false;
      for (const double du : {-0.02, 0.0, 0.02}) {
        for (const double dv : {-0.02, 0.0, 0.02}) {
          explained |= CastRay(queries, camera, instances, u + du, v + dv).id == image.ids(u, v);
        }
      }
      EXPECT_TRUE(explained) << u << " " << v << ": drawn " << image.ids(u, v) << ", ray "
                             << expected.id;
    }
  }
  EXPECT_GT(covered, 3000);
  EXPECT_LT(on_borders, covered / 200);
  EXPECT_LT(worst_m, 2e-5);
  RecordProperty("worst_um", std::to_string(1e6 * worst_m));
}

INSTANTIATE_TEST_SUITE_P(RendererReference, RayCasting,
                         testing::Values(PlainSurfaces::kOwnRaster, PlainSurfaces::kOpenGl),
                         [](const auto& param) {
                           return param.param == PlainSurfaces::kOpenGl ? "OpenGl" : "OwnRaster";
                         });

Pose PoseFromRows(const std::array<double, 12>& m) {
  Pose X = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) X(row, column) = m[4 * row + column];
  }
  return X;
}

// Depth and outlines of two meshes by another renderer (M3T's, by Stoiber): a 16-bit OpenGL depth
// buffer between 0.1 and 2 m, 65535 = empty, and a silhouette with one grey level for each mesh.
TEST(RendererReference, AgreesWithAnotherRenderer) {
  const std::filesystem::path folder =
      std::filesystem::path(PICKBED_TEST_DATA) / "renderer_reference";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no reference pictures in " << folder;
  Renderer renderer({}, kOriginal);
  const int schauma = renderer.AddMesh(LoadMesh(folder / "schauma.obj"));
  const int triangle = renderer.AddMesh(LoadMesh(folder / "triangle.obj"));
  // The reference gives poses as body from world. The vertices of both meshes are shifted along z.
  const Pose X_SW = PoseFromRows({.607676, .408914, -.680823, .297794, .786584, -.428213, .444880,
                                  -.189009, -.109620, -.805867, -.581860, .255284});
  Pose X_TW = X_SW;
  X_TW.translation() = Eigen::Vector3d(.472944, -.213009, .346384);
  Camera camera;
  camera.intrinsics = {640, 480, 698.128, 698.617, 478.459, 274.426};
  camera.SetPose(Translation({-0.01, 0, 0}));
  const std::vector<RenderInstance> instances = {
      {schauma, X_SW.inverse() * Translation({0, 0, -0.097}), 50},
      {triangle, X_TW.inverse() * Translation({0, 0, -0.006}), 150}};
  const RenderedImage image = renderer.RenderDepth(camera, instances);

  constexpr double kNear_m = 0.1, kFar_m = 2.0, kTolerance_m = 5e-5;
  const Image<uint16_t> depth = ReadPng16(folder / "depth_image.png");
  const Image<Rgb8> silhouette = ReadPng(folder / "silhouette_image.png");
  ASSERT_EQ(depth.size(), image.depth_m.size());
  ASSERT_EQ(silhouette.size(), image.depth_m.size());
  int intersection = 0, union_count = 0, near = 0, same_body = 0;
  for (size_t i = 0; i < depth.size(); ++i) {
    const bool theirs = depth.data()[i] != 65535, ours = image.depth_m.data()[i] > 0;
    union_count += theirs || ours;
    if (!theirs || !ours) continue;
    ++intersection;
    same_body += silhouette.data()[i].r == image.ids.data()[i];
    const double clip_z = 2 * depth.data()[i] / 65535.0 - 1;
    const double z = 2 * kNear_m * kFar_m / (kFar_m + kNear_m - clip_z * (kFar_m - kNear_m));
    near += std::abs(z - image.depth_m.data()[i]) < kTolerance_m;
  }
  ASSERT_GT(intersection, 10000);
  EXPECT_GE(intersection, 0.999 * union_count);
  EXPECT_GE(same_body, 0.999 * intersection);
  EXPECT_GE(near, 0.95 * intersection);
  RecordProperty("iou", std::to_string(1.0 * intersection / union_count));
  RecordProperty("depths_within_50_um", std::to_string(1.0 * near / intersection));
}

// The two drivers agree on the same scene: color within one grey level, depth within 10 um, same
// ids.
TEST(RendererReference, OsMesaAndEglAgree) {
  const auto draw = [](GlBackend backend) {
    GlContextOptions options;
    options.backend = backend;
    Renderer renderer(options);
    const Bin bin;
    std::vector<RenderInstance> instances = {{renderer.AddMesh(BinMesh(bin)), Pose::Identity(), 0}};
    Rng rng(4);
    for (const FamilyRow& row : FamilyTable()) {
      const Eigen::Vector3d p(rng.Uniform(-.15, .15), rng.Uniform(-.1, .1), rng.Uniform(.02, .1));
      instances.push_back({renderer.AddMesh(row.make().mesh_O),
                           MakePose(rng.Rotation().toRotationMatrix(), p),
                           static_cast<uint16_t>(instances.size())});
    }
    Camera camera = TestCamera(320, 240, 340);
    camera.SetPose(LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, {0, 0, 1}));
    Light light;
    light.shadow = true;
    return renderer.Render(camera, instances, light, {true, true, true, true});
  };
  RenderedImage a, b;
  try {
    a = draw(GlBackend::kOsMesa);
    b = draw(GlBackend::kEgl);
  } catch (const std::runtime_error& error) {
    GTEST_SKIP() << "only one kind of context can be made here: " << error.what();
  }
  const auto close = [](uint8_t x, uint8_t y) { return std::abs(x - y) <= 1; };
  size_t color = 0, depth = 0, ids = 0, extras = 0;
  for (size_t i = 0; i < a.ids.size(); ++i) {
    const Rgb8 p = a.color.data()[i], q = b.color.data()[i];
    color += close(p.r, q.r) && close(p.g, q.g) && close(p.b, q.b);
    depth += std::abs(a.depth_m.data()[i] - b.depth_m.data()[i]) <= 1e-5;
    ids += a.ids.data()[i] == b.ids.data()[i];
    extras += (a.normals_C.data()[i] - b.normals_C.data()[i]).norm() < 1e-3 &&
              (a.coordinates_O.data()[i] - b.coordinates_O.data()[i]).norm() < 1e-5;
  }
  EXPECT_GE(extras, 0.999 * a.ids.size());
  EXPECT_GE(color, 0.999 * a.ids.size());
  EXPECT_GE(depth, 0.999 * a.ids.size());
  EXPECT_GE(ids, 0.999 * a.ids.size());
  RecordProperty("pixels_that_agree", std::to_string(std::min({color, depth, ids})));
}

}  // namespace
}  // namespace pickbed::tests
