#include "scenes/scenario/load_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

std::shared_ptr<const ObjectModel> LoadObject(const ScenarioSpec& spec, const ObjectSpec& object,
                                              const ObjectCatalog& catalog) {
  if (object.mesh.empty()) return catalog.Load(object.name);
  MeshObjectSpec mesh_object;
  mesh_object.mesh = spec.folder / object.mesh;
  mesh_object.unit = object.unit;
  mesh_object.mass_kg = object.mass_kg;
  mesh_object.density_kgpm3 = object.density_kgpm3;
  mesh_object.friction = object.friction;
  return LoadMeshObject(object.name, mesh_object);
}

// The two smallest sides of the object's bounding box must fit between the walls. The largest one
// must fit on the diagonal.
void RequireFits(const ObjectModel& model, const BinSpec& bin) {
  Eigen::Vector3d size = MeshBounds(model.mesh_O).size();
  std::sort(size.data(), size.data() + 3);
  const Eigen::Vector2d inner = bin.inner_size_m.head<2>();
  if (size[1] <= inner.minCoeff() && size[2] <= inner.norm()) return;
  throw InputError(fmt::format(
      "object '{}' of {:.0f} x {:.0f} x {:.0f} mm is larger than the bin of {:.0f} x {:.0f} mm; "
      "check its unit or choose a larger bin.inner_size_m",
      model.name, 1e3 * size[0], 1e3 * size[1], 1e3 * size[2], 1e3 * inner[0], 1e3 * inner[1]));
}

// Returns the volume of the bin and of a heap above its rim. The heap has sides of 45 degrees, so
// it is a hipped roof.
double RoomOf_m3(const BinSpec& bin) {
  const double length_m = bin.inner_size_m.head<2>().maxCoeff();
  const double width_m = bin.inner_size_m.head<2>().minCoeff();
  const double roof_m3 = width_m * width_m * (3 * length_m - width_m) / 12;
  return bin.inner_size_m.prod() + roof_m3;
}

// Poured objects leave gaps. Cubes and ellipsoids have the densest random packings and fill less
// than 0.8 (Donev et al., Science 2004: 0.735; Jiao and Torquato 2011: 0.78). A drop of more fails
// for every seed, after minutes.
void RequireRoom(const ScenarioSpec& spec, const ObjectSet& objects) {
  constexpr double kDensestScene = 0.8;
  double instances_m3 = 0;
  size_t largest = 0;
  std::vector<double> drawn_m3;  // of all instances that a bin may draw
  const auto volume_m3 = [&](size_t i) {
    return spec.objects[i].count * objects[i]->mass.volume_m3;
  };
  for (size_t i = 0; i < objects.size(); ++i) {
    if (spec.draw > 0 && !spec.objects[i].distractor) {
      drawn_m3.insert(drawn_m3.end(), spec.objects[i].count, objects[i]->mass.volume_m3);
    } else {
      instances_m3 += volume_m3(i);
    }
    if (volume_m3(i) > volume_m3(largest)) largest = i;
  }
  std::sort(drawn_m3.begin(), drawn_m3.end(), std::greater<>());
  drawn_m3.resize(std::min<size_t>(drawn_m3.size(), spec.draw));
  instances_m3 = std::accumulate(drawn_m3.begin(), drawn_m3.end(), instances_m3);
  const double room_m3 = kDensestScene * RoomOf_m3(spec.bin);
  if (instances_m3 <= room_m3) return;
  if (!drawn_m3.empty()) {
    throw InputError(fmt::format(
        "{} = {}: the largest instances that a bin can draw are {:.3g} l, a heap in this bin holds "
        "{:.3g} l at most; lower it, check the objects' unit or choose a larger bin",
        spec.At("draw"), spec.draw, 1e3 * instances_m3, 1e3 * room_m3));
  }
  throw InputError(
      fmt::format("{} = {}: all instances together are {:.3g} l, a heap in this bin holds {:.3g} l "
                  "at most; lower the count, check the objects' unit or choose a larger bin",
                  spec.At(fmt::format("objects.{}.count", largest)), spec.objects[largest].count,
                  1e3 * instances_m3, 1e3 * room_m3));
}

}  // namespace

ObjectSet LoadObjects(const ScenarioSpec& spec, const ObjectCatalog& catalog,
                      const ObjectProgress& on_object) {
  ObjectSet objects;
  for (size_t i = 0; i < spec.objects.size(); ++i) {
    const ObjectSpec& object = spec.objects[i];
    const char* key = object.mesh.empty() ? "name" : "mesh";
    WithSettingsKey(spec, fmt::format("objects.{}.{}", i, key), [&] {
      objects.push_back(LoadObject(spec, object, catalog));
      RequireFits(*objects.back(), spec.bin);
    });
    if (on_object) on_object(static_cast<int>(i + 1), static_cast<int>(spec.objects.size()));
  }
  int wanted = 0;
  for (const ObjectSpec& object : spec.objects) wanted += object.distractor ? 0 : object.count;
  CheckInput(spec.draw <= wanted,
             fmt::format("{} = {}: the objects have only {} instances; raise their counts or lower "
                         "it",
                         spec.At("draw"), spec.draw, wanted));
  if (spec.fill == 0) RequireRoom(spec, objects);
  return objects;
}

}  // namespace pickbed::scenes
