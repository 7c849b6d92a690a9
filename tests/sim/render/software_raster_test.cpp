// Compares the software rasterizer with OpenGL, and tests that adjacent faces share no pixel and
// leave no gap.

#include "sim/render/software_raster.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "scenes/base/random.h"
#include "scenes/bin/bin.h"
#include "scenes/part_families/part_families.h"
#include "tests/sim/render_support.h"

namespace pickbed::tests {
namespace {

// Closed and open, smooth and flat meshes, with many small and with few large faces.
std::vector<TriangleMesh> Shapes() {
  std::vector<TriangleMesh> shapes = {SphereMesh(0.05, 3), BoxMesh({0.12, 0.08, 0.05}),
                                      RectangleMesh(-0.05, -0.04, 0.06, 0.03), BinMesh(Bin())};
  for (const FamilyRow& row : FamilyTable()) {
    const TriangleMesh mesh = row.make().mesh_O;
    if (mesh.texture.empty()) shapes.push_back(mesh);
  }
  return shapes;
}

struct RandomInstances {
  RandomInstances(const std::vector<int>& meshes, uint64_t seed) {
    Rng rng(seed);
    for (const int mesh : meshes) {
      const Eigen::Vector3d p(rng.Uniform(-0.2, 0.2), rng.Uniform(-0.15, 0.15),
                              rng.Uniform(0, 0.1));
      instances.push_back({mesh, MakePose(rng.Rotation().toRotationMatrix(), p),
                           static_cast<uint16_t>(instances.size() + 1)});
      instances.back().material.tint = {0.9, rng.Uniform(0.3, 1.0), 0.7};
    }
    camera = TestCamera(320, 240, 340);
    camera.SetPose(LookAt({0.1, -0.4, 0.7}, {0, 0, 0}, {0, 0, 1}));
  }
  std::vector<RenderInstance> instances;
  Camera camera;
};

// Returns the fraction of pixels with the same id, color within one grey level and depth within
// 0.01 mm.
double AgreeingFraction(const RenderedImage& a, const RenderedImage& b) {
  const auto close = [](uint8_t x, uint8_t y) { return std::abs(x - y) <= 1; };
  size_t same = 0;
  for (size_t i = 0; i < a.depth_m.size(); ++i) {
    const Rgb8 p = a.color.data()[i], q = b.color.data()[i];
    same += close(p.r, q.r) && close(p.g, q.g) && close(p.b, q.b) &&
            std::abs(a.depth_m.data()[i] - b.depth_m.data()[i]) <= 1e-5 &&
            a.ids.data()[i] == b.ids.data()[i];
  }
  return static_cast<double>(same) / a.depth_m.size();
}

TEST(CpuRaster, MatchesOpenGl) {
  Renderer software, open_gl({}, {}, PlainSurfaces::kOpenGl);
  std::vector<int> meshes;
  for (const TriangleMesh& shape : Shapes()) {
    meshes.push_back(software.AddMesh(shape));
    ASSERT_EQ(open_gl.AddMesh(shape), meshes.back());
  }
  for (const uint64_t seed : {1, 2, 3}) {
    const RandomInstances a(meshes, seed), b(meshes, seed);
    const RenderedImage drawn = software.Render(a.camera, a.instances);
    const RenderedImage expected = open_gl.Render(b.camera, b.instances);
    const auto covered = std::count_if(expected.ids.pixels().begin(), expected.ids.pixels().end(),
                                       [](uint16_t id) { return id > 0; });
    EXPECT_GT(covered, 20000);
    EXPECT_GE(AgreeingFraction(drawn, expected), 0.9995) << "seed " << seed;

    const std::vector<Camera> cameras(a.instances.size(), a.camera);
    const std::vector<RenderedImage> views = software.RenderEach(cameras, a.instances);
    const std::vector<RenderedImage> expected_views = open_gl.RenderEach(cameras, b.instances);
    const std::vector<int> counts = software.CountEach(cameras, a.instances);
    const std::vector<int> expected_counts = open_gl.CountEach(cameras, b.instances);
    for (size_t i = 0; i < views.size(); ++i) {
      EXPECT_GE(AgreeingFraction(views[i], expected_views[i]), 0.9995) << "view " << i;
      EXPECT_NEAR(counts[i], expected_counts[i], 1 + 0.001 * expected_counts[i]) << "view " << i;
    }
  }
}

// Returns a disc of `slices` triangles around a pixel center, at depth 1 m for a camera with 1 mm
// per pixel. For large discs, every second vertex is on a pixel center too.
TriangleMesh Disc(double radius_px, int slices, Rng& rng) {
  TriangleMesh mesh;
  mesh.vertices.push_back({0, 0, 1});
  for (int i = 0; i < slices; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.5 * rng.Uniform()) / slices;
    Eigen::Vector2d p(radius_px * std::cos(angle), radius_px * std::sin(angle));
    if (i % 2 && radius_px > 2 * slices) p = p.array().round();  // smaller discs would fold
    mesh.vertices.push_back({1e-3 * p.x(), 1e-3 * p.y(), 1});
    mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % slices});
  }
  return mesh;
}

int Covered(CpuRaster& raster, const CameraIntrinsics& camera, const ImageBox& box,
            const TriangleMesh& mesh) {
  raster.Begin(camera, box);
  raster.Draw(RasterMesh(mesh), {});
  return raster.CountCovered();
}

TEST(CpuRaster, AdjacentFacesShareNoPixelAndLeaveNoGap) {
  const CameraIntrinsics camera{401, 401, 1000, 1000, 200, 200};
  const ImageBox whole{0, 0, 401, 401};
  CpuRaster raster;
  Rng rng(5);
  for (const double radius_px : {1.5, 4.0, 11.0, 29.0, 45.0, 90.0, 190.0}) {
    for (const int slices : {3, 7, 40}) {
      const TriangleMesh disc = Disc(radius_px, slices, rng);
      int sum = 0;
      for (const Eigen::Vector3i& t : disc.triangles) {
        TriangleMesh slice = disc;
        slice.triangles = {t};
        sum += Covered(raster, camera, whole, slice);
      }
      EXPECT_GT(sum, 0);
      EXPECT_EQ(sum, Covered(raster, camera, whole, disc))
          << radius_px << " px in " << slices << " slices";
    }
  }
}

// With corners on pixel centers, the first column and row are covered and the last are not.
TEST(CpuRaster, RectangleOnPixelCentersCoversWidthTimesHeight) {
  const CameraIntrinsics camera{200, 150, 1000, 1000, 0, 0};
  CpuRaster raster;
  for (const auto& [width, height] : {std::array{1, 1}, {3, 2}, {17, 40}, {150, 100}}) {
    TriangleMesh mesh = RectangleMesh(0.010, 0.020, 0.010 + 1e-3 * width, 0.020 + 1e-3 * height);
    for (Eigen::Vector3d& v : mesh.vertices) v.z() = 1;
    EXPECT_EQ(Covered(raster, camera, {0, 0, 200, 150}, mesh), width * height);
    // Pixels beyond the right and lower border of the image are not counted.
    EXPECT_EQ(Covered(raster, camera, {0, 0, 11, 21}, mesh), 1);
  }
}

TEST(CpuRaster, ImageDoesNotDependOnThePreviousImage) {
  const TriangleMesh sphere = SphereMesh(0.05, 2);
  RasterInstance instance;
  instance.X_CO = Translation({0.01, 0, 0.5});
  instance.albedo = {1, 0.5, 0.2};
  instance.id = 7;
  const auto draw = [&](CpuRaster& raster, int width, int height) {
    const Camera camera = TestCamera(width, height, 100);
    RenderedImage image{Image<Rgb8>(width, height),
                        Image<float>(width, height),
                        Image<uint16_t>(width, height),
                        {},
                        {}};
    raster.Begin(camera.intrinsics, {0, 0, width, height});
    raster.Draw(RasterMesh(sphere), instance);
    raster.Write({}, {0, 0, 0}, image);
    return image;
  };
  CpuRaster used;
  for (const auto& [width, height] : {std::array{40, 30}, {15, 40}, {64, 64}, {9, 9}, {40, 30}}) {
    CpuRaster fresh;
    const RenderedImage a = draw(used, width, height), b = draw(fresh, width, height);
    EXPECT_EQ(a.depth_m, b.depth_m);
    EXPECT_EQ(a.ids, b.ids);
    EXPECT_EQ(a.color, b.color);
  }
}

}  // namespace
}  // namespace pickbed::tests
