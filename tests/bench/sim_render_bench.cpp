// Pictures and sensor noise, on one core: workers are processes with a context each. (Two contexts
// in one process would share the driver's lock.)

#include <benchmark/benchmark.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "scenes/part_families.h"
#include "sim/renderer.h"
#include "sim/sensor_noise.h"

namespace pickbed {
namespace {

ObjectSet AllParts() {
  ObjectSet objects;
  for (const PartRow& row : PartTable()) {
    auto model = std::make_shared<ObjectModel>();
    model->mesh_O = row.make().mesh_O;
    objects.push_back(model);
  }
  return objects;
}

Camera CellCamera() {
  Camera camera;
  camera.X_WC = LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, {0, 0, 1});
  return camera;
}

// Parts of all kinds in turn, thrown about in the bin without physics: what is drawn is the same.
Scene Bin30(int kinds) {
  Rng rng(3);
  Scene scene;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.16, 0.16), rng.Uniform(-0.11, 0.11),
                            rng.Uniform(0.02, 0.10));
    scene.objects.push_back({i, i % kinds, MakePose(rng.Rotation().toRotationMatrix(), p)});
  }
  return scene;
}

void RenderBin30(benchmark::State& state) {
  const ObjectSet objects = AllParts();
  const Scene scene = Bin30(static_cast<int>(objects.size()));
  SceneRenderer renderer(objects, scene.bin);
  const Camera camera = CellCamera();
  benchmark::DoNotOptimize(renderer.Render(scene, camera));  // compiles the shaders
  for (auto _ : state) benchmark::DoNotOptimize(renderer.Render(scene, camera));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(RenderBin30)->Name("render/bin30/640x480");

void VisibleFractionsOfBin30(benchmark::State& state) {
  const ObjectSet objects = AllParts();
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

// The number of views at once, of a smooth part of 1,152 triangles or fewer by level of detail.
void RenderViews(benchmark::State& state) {
  const auto views = static_cast<size_t>(state.range(0));
  Renderer renderer;
  const int mesh = renderer.AddMesh(PartTable().back().make().mesh_O);
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

// Every effect of the profile on a full bin in colour.
void SeeBin30(benchmark::State& state, const char* sensor) {
  const SensorProfile profile = LoadSensorProfile(sensor);
  const ObjectSet objects = AllParts();
  const Scene scene = Bin30(static_cast<int>(objects.size()));
  SceneRenderer renderer(objects, scene.bin);
  const Camera camera = CellCamera();
  const RenderedImage image = renderer.Render(scene, camera);
  const IdealView view{image.depth_m, camera.intrinsics, &image.color};
  Rng rng(1);
  for (auto _ : state) benchmark::DoNotOptimize(ApplySensorNoise(view, profile, rng));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK_CAPTURE(SeeBin30, structured_light, "structured_light")
    ->Name("sensor/structured_light/640x480");
BENCHMARK_CAPTURE(SeeBin30, active_stereo, "active_stereo")->Name("sensor/active_stereo/640x480");
BENCHMARK_CAPTURE(SeeBin30, time_of_flight, "time_of_flight")
    ->Name("sensor/time_of_flight/640x480");

}  // namespace
}  // namespace pickbed
