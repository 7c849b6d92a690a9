// Long measurements of clutter scenes, printed to stdout:
//   physics_figures certified SCENES   50 instances (bracket, tee, gear) per scene,
//                                      checked with meshes
//   physics_figures parts100 SCENES    100 instances per scene
//   physics_figures sizes SCENES       the same objects at 10 cm and at 1 cm
//   physics_figures memory SCENES      scenes dropped, rendered and passed to a sensor
//                                      in one process

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/objects/object_catalog.h"
#include "sim/convex/convex_pieces.h"
#include "sim/drop/certified_scene.h"
#include "sim/render/renderer.h"
#include "sim/sensor/depth_noise.h"
#include "tests/support/mesh_overlap.h"

namespace pickbed::tests {
namespace {

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

ObjectSet ConcaveObjects() {
  const ObjectCatalog catalog({AssetsDir() / "objects"});
  ObjectSet objects;
  for (const char* name : {"bracket", "pipe_tee", "gear"}) objects.push_back(catalog.Load(name));
  return WithConvexPieces(objects);
}

std::vector<int> SpreadEvenly(int instances, size_t object_count) {
  std::vector<int> counts(object_count, 0);
  for (int i = 0; i < instances; ++i) ++counts[i % object_count];
  return counts;
}

// Drops scenes, counts refused ones and measures the overlap of accepted ones with meshes.
void MeasureScenes(const std::string& title, const Bin& bin, const ObjectSet& objects,
                   int instances, int scenes) {
  double seconds = 0, slowest_s = 0, certificate_m = 0, mesh_m = 0;
  int refused = 0, lost = 0, missing = 0;
  for (int trial = 0; trial < scenes; ++trial) {
    const double begin_s = CpuSeconds();
    const CertifiedScene made =
        MakeScene({bin, objects, SpreadEvenly(instances, objects.size()), 0, BinIndex(trial)});
    const double scene_s = CpuSeconds() - begin_s;
    seconds += scene_s;
    slowest_s = std::max(slowest_s, scene_s);
    refused += static_cast<int>(made.refused.size());
    for (const RefusedScene& scene : made.refused) {
      fmt::print("  trial {} drop {} rejected: {}\n", trial, scene.attempt, scene.faults[0]);
    }
    missing += instances - static_cast<int>(made.scene.objects.size());
    certificate_m = std::max(certificate_m, made.certificate.deepest_penetration_m);
    const MeshOverlap overlap = MeasureMeshOverlap(made.scene, objects);
    mesh_m = std::max(mesh_m, overlap.deepest_m);
    lost += overlap.lost;
    if (overlap.deepest_m > 0.0005) {
      fmt::print("  trial {}: meshes overlap by {:.3f} mm\n", trial, 1e3 * overlap.deepest_m);
    }
    std::fflush(stdout);
  }
  fmt::print(
      "{}: {} scenes of {} instances; {} of {} drops rejected ({:.2f} %); {:.2f} CPU s per scene "
      "including rejected drops, slowest {:.2f}; deepest overlap {:.3f} mm by the certificate, "
      "{:.3f} mm by the meshes; {} instances outside the bin\n",
      title, scenes, instances, refused, refused + scenes, 100.0 * refused / (refused + scenes),
      seconds / scenes, slowest_s, 1e3 * certificate_m, 1e3 * mesh_m, lost + missing);
}

std::shared_ptr<const ObjectModel> WithDiameter(const ObjectModel& model, double diameter_m) {
  const double s = diameter_m / model.diameter_m;
  auto scaled = std::make_shared<ObjectModel>(model);
  scaled->mesh_O = Scaled(model.mesh_O, s);
  scaled->diameter_m = diameter_m;
  scaled->mass.mass_kg *= s * s * s;
  scaled->mass.volume_m3 *= s * s * s;
  scaled->mass.com_O *= s;
  scaled->mass.inertia_com_O *= s * s * s * s * s;
  for (ConvexPiece& piece : scaled->convex_pieces_O) {
    for (Eigen::Vector3d& p : piece.vertices_O) p *= s;
  }
  return scaled;
}

// Scales the bin with the objects; the default bin belongs to objects of 10 cm.
void MeasureSizes(int scenes) {
  for (const double diameter_m : {0.1, 0.01}) {
    ObjectSet objects;
    for (const auto& object : ConcaveObjects())
      objects.push_back(WithDiameter(*object, diameter_m));
    Bin bin;
    bin.inner_size_m *= diameter_m / 0.1;
    MeasureScenes(fmt::format("objects of {:.0f} mm", 1e3 * diameter_m), bin, objects, 30, scenes);
  }
}

double ResidentMiB() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

double Mean(const std::vector<double>& values, size_t from, size_t to) {
  return std::accumulate(values.begin() + from, values.begin() + to, 0.0) / (to - from);
}

// Repeats the same ten scenes, so that times are comparable.
void MeasureMemory(int scenes) {
  const ObjectSet objects = ConcaveObjects();
  Camera camera;
  camera.intrinsics = {320, 240, 340, 340, 159.5, 119.5};
  camera.SetPose(LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, Eigen::Vector3d::UnitZ()));
  SceneRenderer renderer(objects, Bin{});
  const SensorProfile sensor = LoadSensorProfile("structured_light");
  std::vector<double> seconds, resident_mib;
  for (int i = 0; i < scenes; ++i) {
    const double begin_s = CpuSeconds();
    const CertifiedScene made = MakeScene({Bin{}, objects, {2, 2, 2}, 0, BinIndex(i % 10)});
    const RenderedImage image = renderer.Render(made.scene, camera);
    const auto fractions = renderer.VisibleFractions(made.scene, camera, image.ids);
    Rng rng = Rng::Derive(0, i, "sensor");
    ApplySensorNoise({image.depth_m, camera.intrinsics, &image.color}, sensor, rng);
    seconds.push_back(CpuSeconds() - begin_s);
    resident_mib.push_back(ResidentMiB());
    if ((i + 1) % 100 == 0) {
      fmt::print("  after {:>5}: {:.1f} MiB, {:.4f} CPU s per scene\n", i + 1, resident_mib.back(),
                 Mean(seconds, i - 99, i + 1));
      std::fflush(stdout);
    }
  }
  const size_t settled = std::min(seconds.size() - 1, size_t{99});
  const auto last = std::max_element(resident_mib.begin() + settled, resident_mib.end());
  const size_t round = std::min(seconds.size() / 2, size_t{10});
  const double first_s = Mean(seconds, round, 2 * round);
  const double last_s = Mean(seconds, seconds.size() - round, seconds.size());
  fmt::print(
      "memory: {:.1f} MiB after {} scenes, at most {:.1f} MiB later ({:+.2f} %); scenes {} to {} "
      "took {:.4f} CPU s each, the last {} {:.4f} ({:+.1f} %)\n",
      resident_mib[settled], settled + 1, *last, 100 * (*last / resident_mib[settled] - 1),
      round + 1, 2 * round, first_s, round, last_s, 100 * (last_s / first_s - 1));
}

int Main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[1] : "";
  const int scenes = argc == 3 ? std::atoi(argv[2]) : 0;
  if (scenes < 1) {
    fmt::print(stderr, "physics_figures certified|parts100|sizes|memory SCENES\n");
    return 1;
  }
  if (what == "certified") MeasureScenes("certified", Bin{}, ConcaveObjects(), 50, scenes);
  if (what == "parts100") MeasureScenes("parts100", Bin{}, ConcaveObjects(), 100, scenes);
  if (what == "sizes") MeasureSizes(scenes);
  if (what == "memory") MeasureMemory(scenes);
  return 0;
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) { return pickbed::tests::Main(argc, argv); }
