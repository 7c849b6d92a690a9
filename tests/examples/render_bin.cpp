// Fills a bin, and renders it as a color image and as the depth image of a real sensor.
//
//   render_bin FOLDER    writes FOLDER/color.png and FOLDER/depth.png

#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"

using namespace pickbed::scenes;
using namespace pickbed::sim;

namespace {

void RenderBin(const std::filesystem::path& folder) {
  // Objects of the shipped catalog. Physics needs their convex pieces.
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  const ObjectSet objects =
      WithConvexPieces(ObjectSet{catalog.Load("pipe_tee"), catalog.Load("ring")});

  // Twelve instances of the first object and eight of the second fall into the bin and come to
  // rest.
  const uint64_t seed = 1;
  const BinIndex bin_index(0);
  const Bin bin{.inner_size_m = {0.40, 0.30, 0.15}};
  const Scene scene = MakeScene({bin, objects, {12, 8}, seed, bin_index}).scene;

  // A camera 85 cm above the floor, slightly tilted. X_WC is its pose in the world frame W.
  const Pose X_WC = LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, Eigen::Vector3d::UnitZ());
  const Camera camera(CameraIntrinsics(640, 480, 680, 680, 319.5, 239.5), X_WC);

  // The ideal image: color, depth in metres and the instance of each pixel.
  SceneRenderer renderer(objects, bin);
  const RenderedImage image = renderer.Render(scene, camera);

  // The sensor loses readings at edges and on dark surfaces, and adds noise to the others.
  Rng rng = Rng::Derive(seed, bin_index, "sensor");
  const SensorProfile sensor = LoadSensorProfile("structured_light");
  const Image<float> depth_m =
      ApplySensorNoise({image.depth_m, camera.intrinsics, &image.color}, sensor, rng);

  WritePng(folder / "color.png", image.color);
  WriteDepthPng(folder / "depth.png", depth_m);  // 16 bit, in units of 0.1 mm

  const auto readings = std::count_if(depth_m.pixels().begin(), depth_m.pixels().end(),
                                      [](float z_m) { return z_m > 0; });
  std::printf("pixels with a reading: %.1f %%\n", 100.0 * readings / depth_m.size());
  const std::vector<double> visible = renderer.VisibleFractions(scene, camera, image.ids);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& posed = scene.objects[i];
    const Eigen::Vector3d p_WO = posed.X_WO.translation();
    std::printf("%s at (%.3f, %.3f, %.3f) m: visible %.0f %%\n",
                objects[posed.object]->name.c_str(), p_WO.x(), p_WO.y(), p_WO.z(),
                100 * visible[i]);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  RenderBin(argc > 1 ? argv[1] : ".");
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
