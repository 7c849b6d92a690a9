#include "eval/bop/stored_scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "eval/bop/json.h"
#include "eval/bop/layout.h"
#include "eval/bop/read_dataset.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

namespace fs = std::filesystem;

constexpr int kFormat = 1;
constexpr double kMaxDeviation = 10;  // of friction, mass and size, as a share
constexpr double kFarthest_m = 100;
constexpr double kMaxRotationError = 1e-6;

bool SameObjects(const Scene& a, const Scene& b) {
  return std::ranges::equal(a.objects, b.objects, [](const PosedObject& p, const PosedObject& q) {
    return p.instance == q.instance && p.object == q.object && p.deviation == q.deviation &&
           p.X_WO.matrix() == q.X_WO.matrix();
  });
}

ParsedJson Numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ParsedJson InstanceJson(const PosedObject& posed) {
  ParsedJson rotation = ParsedJson::array();
  for (int i = 0; i < 9; ++i) rotation.push_back(posed.X_WO.linear()(i / 3, i % 3));
  return {{"instance", int{posed.instance}},
          {"obj_id", int{posed.object} + 1},
          {"R", rotation},
          {"t_m", Numbers(posed.X_WO.translation())},
          {"friction_deviation", posed.deviation.friction},
          {"mass_deviation", posed.deviation.mass}};
}

ParsedJson ObjectJson(const ObjectModel& object, int object_id, double size) {
  return {{"obj_id", object_id},
          {"name", object.name},
          {"mesh", fmt::format("{:016x}", object.mesh_hash)},
          {"mass_kg", object.mass.mass_kg},
          {"friction", object.friction},
          {"size_deviation", size}};
}

ParsedJson BinJson(const Bin& bin) {
  return {{"inner_size_m", Numbers(bin.inner_size_m)},
          {"wall_m", bin.wall_m},
          {"friction", bin.friction}};
}

std::string ListText(const std::vector<std::string>& entries) {
  return fmt::format("[\n    {}\n  ]", fmt::join(entries, ",\n    "));
}

PosedObject InstanceOf(const ParsedJson& entry, const ObjectSet& objects, const JsonPlace& place) {
  PosedObject posed;
  posed.instance = InstanceId(JsonInteger(entry, "instance", place).value());
  const int object_id = JsonInteger(entry, "obj_id", place).value();
  if (object_id < 1 || object_id > static_cast<int>(objects.size())) {
    place.Fault(fmt::format("obj_id {} is not in the scenario", object_id));
  }
  posed.object = ObjectId(object_id - 1);
  const auto R = JsonReals(entry, "R", 9, place);
  const auto t_m = JsonReals(entry, "t_m", 3, place);
  if (const std::string wrong = RotationFault(ToMatrix3(*R)); !wrong.empty()) {
    (place / "'R'").Fault(wrong);
  }
  // The rotations of published data sets are rounded, but this file has all their digits.
  if (!ToMatrix3(*R).isUnitary(kMaxRotationError)) {
    (place / "'R'").Fault("is no rotation, but was written with all digits");
  }
  posed.X_WO = MakePose(ToMatrix3(*R), Eigen::Vector3d::Map(t_m->data()));
  posed.deviation.friction = entry.at("friction_deviation").get<double>();
  posed.deviation.mass = entry.at("mass_deviation").get<double>();
  for (const double deviation : {posed.deviation.friction, posed.deviation.mass}) {
    if (!(deviation > -1 && deviation < kMaxDeviation)) {
      place.Fault(fmt::format("an instance deviates by {:g} times its model", deviation));
    }
  }
  if (posed.X_WO.translation().norm() > kFarthest_m) {
    (place / "'t_m'")
        .Fault(fmt::format("an instance is {:g} m from the bin", posed.X_WO.translation().norm()));
  }
  return posed;
}

// Throws InputError unless the stored objects are the given ones.
void RequireSameObjects(const ParsedJson& stored, const ObjectSet& objects, const fs::path& file) {
  CheckInput(stored.size() == objects.size(),
             fmt::format("{}: was made with {} objects, the scenario has {}", file.string(),
                         stored.size(), objects.size()));
  for (size_t i = 0; i < objects.size(); ++i) {
    const ParsedJson& was = stored[i];
    const ParsedJson is =
        ObjectJson(*objects[i], static_cast<int>(i) + 1, was.at("size_deviation"));
    CheckInput(was == is,
               fmt::format("{}: object {} differs now from the one that the scenes were made with "
                           "(name, mesh, mass or friction); restore it, or make the dataset again",
                           file.string(), was.at("name").get<std::string>()));
  }
}

}  // namespace

void StoredScenes::Add(int image_id, const Scene& scene) {
  if (scenes.empty() || !SameObjects(scenes.back(), scene)) scenes.push_back(scene);
  of_image[image_id] = scenes.size() - 1;
}

const Scene& StoredScenes::Of(int image_id, const fs::path& folder) const {
  const auto found = of_image.find(image_id);
  CheckInput(found != of_image.end(), fmt::format("{}: has no scene of image {}",
                                                  (folder / kStoredScenesFile).string(), image_id));
  return scenes[found->second];
}

std::string StoredScenesText(const StoredScenes& stored, const ObjectSet& objects) {
  std::vector<std::string> models, scenes;
  for (size_t i = 0; i < objects.size(); ++i) {
    models.push_back(ObjectJson(*objects[i], static_cast<int>(i) + 1, stored.sizes.at(i)).dump());
  }
  for (const Scene& scene : stored.scenes) {
    ParsedJson instances = ParsedJson::array();
    for (const PosedObject& posed : scene.objects) instances.push_back(InstanceJson(posed));
    scenes.push_back(ParsedJson{{"instances", instances}}.dump());
  }
  ParsedJson images = ParsedJson::object();
  for (const auto& [id, scene] : stored.of_image) images[std::to_string(id)] = scene;
  const Bin bin = stored.scenes.empty() ? Bin() : stored.scenes.front().bin;
  return fmt::format(
      "{{\n  \"format\": {},\n  \"seed\": {},\n  \"bin_index\": {},\n  \"bin\": {},\n"
      "  \"objects\": {},\n  \"images\": {},\n  \"scenes\": {}\n}}\n",
      kFormat, stored.seed, int{stored.bin_index}, BinJson(bin).dump(), ListText(models),
      images.dump(), ListText(scenes));
}

StoredScenes ReadStoredScenes(const fs::path& folder, const Bin& bin, const ObjectSet& objects) {
  const fs::path file = folder / kStoredScenesFile;
  CheckInput(fs::exists(file),
             fmt::format("{}: is missing, so nothing can be executed in this dataset; `pickbed "
                         "dataset make` and `pickbed run --bop-out` store the scenes",
                         file.string()));
  const ParsedJson json = *ReadJson(file, ThrowFault);
  const OnFault fault = ThrowFault;
  const JsonPlace place(file.string(), fault);
  StoredScenes stored;
  try {
    CheckInput(json.at("format") == kFormat,
               fmt::format("{}: has format {}, not {}; it is from another version of pickbed",
                           file.string(), json.at("format").dump(), kFormat));
    // A conversion would turn other numbers into wrong ones without an error.
    CheckInput(json.at("seed").is_number_unsigned(),
               fmt::format("{}: seed {} is not a whole number from 0", file.string(),
                           json.at("seed").dump()));
    stored.seed = json.at("seed").get<uint64_t>();
    stored.bin_index = BinIndex(JsonInteger(json, "bin_index", place).value());
    CheckInput(json.at("bin") == BinJson(bin),
               fmt::format("{}: was made with another bin than the scenario has", file.string()));
    RequireSameObjects(json.at("objects"), objects, file);
    for (const ParsedJson& object : json.at("objects")) {
      stored.sizes.push_back(object.at("size_deviation").get<double>());
      if (!(stored.sizes.back() > -1 && stored.sizes.back() < kMaxDeviation)) {
        place.Fault(fmt::format("an object deviates by {:g} times its size", stored.sizes.back()));
      }
    }
    for (const ParsedJson& stored_scene : json.at("scenes")) {
      Scene& scene = stored.scenes.emplace_back();
      scene.bin = bin;
      std::set<InstanceId> instances;
      for (const ParsedJson& entry : stored_scene.at("instances")) {
        scene.objects.push_back(InstanceOf(entry, objects, place));
        if (!instances.insert(scene.objects.back().instance).second) {
          place.Fault(fmt::format("a scene has instance {} twice", entry.at("instance").dump()));
        }
      }
    }
    for (const auto& [key, index] : json.at("images").items()) {
      if (!index.is_number_unsigned() || index.get<size_t>() >= stored.scenes.size()) {
        place.Fault(fmt::format("image {} has scene {}, which is not there", key, index.dump()));
      }
      stored.of_image[ParseId(key).value()] = index.get<size_t>();
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError(fmt::format("{}: was not written by pickbed, or is damaged ({})",
                                 file.string(), error.what()));
  }
  return stored;
}

}  // namespace pickbed::eval
