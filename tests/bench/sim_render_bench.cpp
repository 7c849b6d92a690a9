// Benchmarks of rendering and sensor noise. Names that end in /cores:N are measured on N processes
// with one context each, as in the program's workers. (Two contexts in one process would share the
// driver's lock.)

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <numbers>
#include <vector>

#include "scenes/part_families/part_families.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"
#include "tests/bench/processes.h"

namespace pickbed::tests {
namespace {

ObjectSet AllObjects() {
  ObjectSet objects;
  for (const FamilyRow& row : FamilyTable()) {
    auto model = std::make_shared<ObjectModel>();
    model->mesh_O = row.make().mesh_O;
    objects.push_back(model);
  }
  return objects;
}

Camera CellCamera() {
  Camera camera;
  camera.SetPose(LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, {0, 0, 1}));
  return camera;
}

// Returns 30 instances of alternating objects at random poses, without physics. The render time is
// the same as for a settled scene.
Scene Bin30(int object_count) {
  Rng rng(3);
  Scene scene;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.16, 0.16), rng.Uniform(-0.11, 0.11),
                            rng.Uniform(0.02, 0.10));
    scene.objects.push_back({InstanceId(i), ObjectId(i % object_count),
                             MakePose(rng.Rotation().toRotationMatrix(), p)});
  }
  return scene;
}

void RenderBin30(benchmark::State& state) {
  const ObjectSet objects = AllObjects();
  const Scene scene = Bin30(static_cast<int>(objects.size()));
  SceneRenderer renderer(objects, scene.bin);
  const Camera camera = CellCamera();
  benchmark::DoNotOptimize(renderer.Render(scene, camera));  // compiles the shaders
  for (auto _ : state) benchmark::DoNotOptimize(renderer.Render(scene, camera));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(RenderBin30)->Name("render/bin30/640x480");

void VisibleFractionsOfBin30(benchmark::State& state) {
  const ObjectSet objects = AllObjects();
  const Scene scene = Bin30(static_cast<int>(objects.size()));
  SceneRenderer renderer(objects, scene.bin);
  const Camera camera = CellCamera();
  const RenderedImage image = renderer.Render(scene, camera);
  for (auto _ : state) {
    benchmark::DoNotOptimize(renderer.VisibleFractions(scene, camera, image.ids));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(VisibleFractionsOfBin30)->Name("render/visible_fractions/bin30");

// Returns a smooth closed ring of 2 x around x across triangles. It is curved everywhere, so that
// levels of detail reduce it as little as possible.
TriangleMesh Ring(double radius_m, double thickness_m, int around, int across) {
  TriangleMesh mesh;
  const auto index = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i) {
    const double a = 2 * std::numbers::pi * i / around;
    for (int j = 0; j < across; ++j) {
      const double b = 2 * std::numbers::pi * j / across;
      const Eigen::Vector3d normal(std::cos(b) * std::cos(a), std::cos(b) * std::sin(a),
                                   std::sin(b));
      mesh.vertices.push_back(radius_m * Eigen::Vector3d(std::cos(a), std::sin(a), 0) +
                              0.5 * thickness_m * normal);
      mesh.normals.push_back(normal);
      mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  return mesh;
}

ObjectSet RingOf2304() {
  auto model = std::make_shared<ObjectModel>();
  model->mesh_O = Ring(0.03, 0.024, 48, 24);
  return {model};
}

// Frames per second of one 2,304-triangle object over a seventh of the image, in steps of 100.
void RenderOne(benchmark::State& state, DetailOptions detail,
               PlainSurfaces surfaces = PlainSurfaces::kOwnRaster) {
  MeasureInProcesses(state, 100, [detail, surfaces] {
    auto renderer = std::make_shared<Renderer>(GlContextOptions{}, detail, surfaces);
    const int mesh = renderer->AddMesh(Ring(0.06, 0.06, 48, 24));
    Rng rng(2);
    const Pose X_CO = MakePose(rng.Rotation().toRotationMatrix(), {0.02, -0.01, 0.42});
    return [=] {
      benchmark::DoNotOptimize(
          renderer->Render(Camera(), std::vector{RenderInstance{mesh, X_CO, 1}}));
    };
  });
}
BENCHMARK_CAPTURE(RenderOne, levels, DetailOptions{})
    ->Name("render/one2304/640x480")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();
BENCHMARK_CAPTURE(RenderOne, original, DetailOptions{0, 0})
    ->Name("render/one2304_original/640x480")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();

BENCHMARK_CAPTURE(RenderOne, open_gl, DetailOptions{}, PlainSurfaces::kOpenGl)
    ->Name("render/one2304_open_gl/640x480")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();

// 30 instances of 2,304 triangles in a bin: color, depth and ids, optionally with every visible
// fraction.
void RenderBin30Of2304(benchmark::State& state, bool fractions) {
  MeasureInProcesses(state, 20, [fractions] {
    const Scene scene = Bin30(1);
    auto renderer = std::make_shared<SceneRenderer>(RingOf2304(), scene.bin);
    return [=] {
      const RenderedImage image = renderer->Render(scene, CellCamera());
      if (fractions) {
        benchmark::DoNotOptimize(renderer->VisibleFractions(scene, CellCamera(), image.ids));
      }
      benchmark::DoNotOptimize(image);
    };
  });
}
BENCHMARK_CAPTURE(RenderBin30Of2304, image, false)
    ->Name("render/bin30x2304/640x480")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();
BENCHMARK_CAPTURE(RenderBin30Of2304, fractions, true)
    ->Name("render/bin30x2304_with_fractions/640x480")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();

// 64x64 views of a 256-triangle mesh, 1024 per call.
void RenderTrainingViews(benchmark::State& state, bool color) {
  constexpr int kViews = 1024;
  MeasureInProcesses(
      state, 2,
      [color] {
        auto renderer = std::make_shared<Renderer>(GlContextOptions{}, DetailOptions{0, 0});
        const int mesh = renderer->AddMesh(Ring(0.03, 0.024, 16, 8));
        Camera camera;
        camera.intrinsics = {64, 64, 500, 500, 31.5, 31.5};
        const std::vector<Camera> cameras(kViews, camera);
        std::vector<RenderInstance> instances;
        Rng rng(1);
        for (int i = 0; i < kViews; ++i) {
          instances.push_back({mesh, MakePose(rng.Rotation().toRotationMatrix(), {0, 0, 0.9}), 1});
        }
        return [=] {
          if (color) {
            benchmark::DoNotOptimize(renderer->RenderEach(cameras, instances));
          } else {
            benchmark::DoNotOptimize(renderer->RenderEachDepth(cameras, instances));
          }
        };
      },
      kViews);
}
BENCHMARK_CAPTURE(RenderTrainingViews, color, true)
    ->Name("render/training_views256/64x64")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();
BENCHMARK_CAPTURE(RenderTrainingViews, depth, false)
    ->Name("render/training_views256_depth/64x64")
    ->ArgName("cores")
    ->Arg(1)
    ->Arg(2)
    ->UseManualTime();

// Renders state.range(0) views per call, of a smooth object with 1,152 triangles or fewer by level
// of detail.
void RenderViews(benchmark::State& state) {
  const auto views = static_cast<size_t>(state.range(0));
  Renderer renderer;
  const int mesh = renderer.AddMesh(FamilyTable().back().make().mesh_O);
  Camera camera;
  camera.intrinsics = {64, 64, 500, 500, 31.5, 31.5};
  const std::vector<Camera> cameras(views, camera);
  std::vector<RenderInstance> instances;
  Rng rng(1);
  for (size_t i = 0; i < views; ++i) {
    instances.push_back({mesh, MakePose(rng.Rotation().toRotationMatrix(), {0, 0, 0.9}), 1});
  }
  for (auto _ : state) benchmark::DoNotOptimize(renderer.RenderEach(cameras, instances));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(RenderViews)->Name("render/views/64x64")->Arg(64)->Arg(1024);

// Applies every effect of the profile to an image of a full bin with color.
void SenseBin30(benchmark::State& state, const char* sensor) {
  const SensorProfile profile = LoadSensorProfile(sensor);
  const ObjectSet objects = AllObjects();
  const Scene scene = Bin30(static_cast<int>(objects.size()));
  SceneRenderer renderer(objects, scene.bin);
  const Camera camera = CellCamera();
  const RenderedImage image = renderer.Render(scene, camera);
  const IdealView view{image.depth_m, camera.intrinsics, &image.color};
  Rng rng(1);
  for (auto _ : state) benchmark::DoNotOptimize(ApplySensorNoise(view, profile, rng));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(SenseBin30, structured_light, "structured_light")
    ->Name("sensor/structured_light/640x480");
BENCHMARK_CAPTURE(SenseBin30, active_stereo, "active_stereo")->Name("sensor/active_stereo/640x480");
BENCHMARK_CAPTURE(SenseBin30, time_of_flight, "time_of_flight")
    ->Name("sensor/time_of_flight/640x480");

}  // namespace
}  // namespace pickbed::tests
