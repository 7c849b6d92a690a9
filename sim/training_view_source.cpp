#include "sim/training_view_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

#include "scenes/base/error.h"
#include "sim/drop/distractors.h"
#include "sim/drop/room.h"
#include "sim/sensor/depth_noise.h"
#include "sim/sensor/sensor_failures.h"

namespace pickbed::sim {
namespace {

constexpr int kIsolatedBatch = 1024;  // views per batch; bounds the memory
constexpr int kSceneAttempts = 3;     // attempts per seed before ClutterScene() throws

// Light beside the camera for isolated views. Their world frame is the camera frame.
const Light kLampByCamera{{0.25, -0.30, -0.10}, 0.35, 0.65};

double BoundingVolume_m3(const ObjectModel& object) {
  return MeshBounds(object.mesh_O).size().prod();
}

// Returns X_WC of a camera that looks down at a target near the center of the bin floor. The roll
// about its optical axis is random. A room is seen from up to twice the distance and at any tilt.
Pose RandomCamera(const ViewSourceOptions& options, double scale, bool in_room, Rng& rng) {
  constexpr double kRoomTilt_rad = 1.15;
  const double jitter = scale * options.target_jitter_m;
  const Eigen::Vector3d target_W(rng.Uniform(-jitter, jitter), rng.Uniform(-jitter, jitter), 0);
  const double farther = in_room ? rng.Uniform(0.8, 1.7) : 1;
  const double distance_m =
      farther * scale * rng.Uniform(options.distance_min_m, options.distance_max_m);
  const double tilt = rng.Uniform(0, in_room ? kRoomTilt_rad : options.tilt_max_rad);
  const double azimuth = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  const double roll = rng.Uniform(-std::numbers::pi, std::numbers::pi);
  using Eigen::AngleAxisd;
  const Eigen::Matrix3d R_WC =
      (AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()) * AngleAxisd(tilt, Eigen::Vector3d::UnitY()) *
       AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
       AngleAxisd(roll, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  return MakePose(R_WC, target_W - distance_m * R_WC.col(2));
}

ObjectSet WithDistractors(const ObjectSet& objects, const ViewSourceOptions& options) {
  ObjectSet all = objects;
  if (options.distractor_share > 0) {
    const ObjectSet foreign = MakeDistractors(objects);
    all.insert(all.end(), foreign.begin(), foreign.end());
  }
  return all;
}

class SimViewSource : public LabelledViewSource {
 public:
  SimViewSource(const ObjectSet& objects, const ViewSourceOptions& options)
      : objects_(objects),
        options_(options),
        in_scenes_(WithDistractors(objects, options)),
        scene_renderer_(in_scenes_, options.bin, options.gl) {}

  const ObjectSet& objects() const override { return objects_; }

  std::vector<LabelledView> Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                     const CameraIntrinsics& camera, uint64_t seed) override;
  std::vector<LabelledView> ClutterScene(const ClutterSceneRequest& request) override;
  std::string IsolatedSettings() const override;
  std::string ClutterSceneSettings() const override;

 private:
  std::vector<RenderedImage> RenderIsolated(std::span<const Camera> cameras,
                                            std::span<const RenderInstance> instances,
                                            uint64_t seed, size_t first);
  // A settled clutter scene. Bin size and camera distances are the options' values times `scale`.
  struct ScaledScene {
    Scene scene;
    double scale = 1;
    bool in_room = false, on_table = false;
  };
  std::vector<ObjectId> RandomKinds(const ClutterSceneRequest& request, Rng& rng) const;
  std::vector<ObjectId> RandomDistractor(const ClutterSceneRequest& request,
                                         const std::vector<ObjectId>& kinds) const;
  std::vector<int> RandomCounts(const std::vector<ObjectId>& kinds,
                                const std::vector<ObjectId>& foreign, const Bin& bin, bool deep,
                                Rng& rng) const;
  double RandomScale(const ClutterSceneRequest& request, const std::vector<ObjectId>& kinds,
                     Rng& rng) const;
  ScaledScene DropScene(const ClutterSceneRequest& request) const;
  const SensorProfile& SceneSensor(uint64_t seed, int view) const;
  SensorProfile RoomSensor(double distance_m, Rng& rng) const;
  void AddRoom(const ScaledScene& clutter_scene, const Camera& camera, Rng& rng,
               std::vector<RenderInstance>& instances);
  Image<float> Sensed(const ScaledScene& clutter_scene, const RenderedImage& image,
                      const Camera& camera, uint64_t seed, int view) const;
  LabelledView SceneView(const ScaledScene& clutter_scene, uint64_t seed, int view);

  // A random stream of its own, so that other scenes do not depend on deep_share.
  bool IsDeep(const ClutterSceneRequest& request) const {
    return Rng::Derive(request.seed, 0, "pile deep").Uniform() < options_.deep_share;
  }
  bool IsDistractor(ObjectId object) const { return object >= static_cast<int>(objects_.size()); }

  ObjectSet objects_;
  ViewSourceOptions options_;
  ObjectSet in_scenes_;  // objects_, then distractors
  SceneRenderer scene_renderer_;
  std::optional<RoomShapes> room_;  // made for the first room
  std::vector<int> room_meshes_;    // handles in scene_renderer_.renderer()
};

// Renders one image per instance. `first` is the index of the first view; it selects the random
// streams.
std::vector<RenderedImage> SimViewSource::RenderIsolated(std::span<const Camera> cameras,
                                                         std::span<const RenderInstance> instances,
                                                         uint64_t seed, size_t first) {
  Renderer& renderer = scene_renderer_.renderer();
  if (!options_.color) return renderer.RenderEachDepth(cameras, instances);
  if (!options_.isolated_lamps) return renderer.RenderEach(cameras, instances, kLampByCamera);
  std::vector<RenderedImage> images;
  for (size_t i = 0; i < instances.size(); ++i) {
    Rng rng = Rng::Derive(seed, first + i, "isolated view lamp");
    Light light = RandomLight(options_.appearance, rng);
    light.position_W.z() = instances[i].X_WO.translation().z() - light.position_W.z();
    images.push_back(
        std::move(renderer.RenderEach(cameras.subspan(i, 1), instances.subspan(i, 1), light)[0]));
  }
  return images;
}

std::vector<LabelledView> SimViewSource::Isolated(ObjectId object, const std::vector<Pose>& X_CO,
                                                  const CameraIntrinsics& camera, uint64_t seed) {
  CheckInput(object >= 0 && object < static_cast<int>(objects_.size()),
             fmt::format("object {} of {} does not exist", object, objects_.size()));
  std::vector<LabelledView> views(X_CO.size());
  for (size_t begin = 0; begin < X_CO.size(); begin += kIsolatedBatch) {
    const size_t end = std::min(X_CO.size(), begin + kIsolatedBatch);
    const std::vector<Camera> cameras(end - begin, Camera{camera, Pose::Identity()});
    std::vector<RenderInstance> instances;
    for (size_t i = begin; i < end; ++i) {
      instances.push_back({scene_renderer_.ObjectMesh(object), X_CO[i], 1});
      Rng appearance = Rng::Derive(seed, i, "isolated view looks");
      instances.back().material = RandomMaterial(options_.appearance, appearance);
    }
    std::vector<RenderedImage> images = RenderIsolated(cameras, instances, seed, begin);
    for (size_t i = begin; i < end; ++i) {
      RenderedImage& image = images[i - begin];
      Rng background = Rng::Derive(seed, i, "isolated view background");
      PaintBackground(options_.appearance, background, image);
      Rng rng = Rng::Derive(seed, i, "isolated view noise");
      Image<float> depth_m =
          ApplySensorNoise({image.depth_m, camera, &image.color}, options_.sensor, rng);
      views[i].frame = {camera, std::move(image.color), std::move(depth_m)};
      views[i].ids = std::move(image.ids);
      views[i].instances = {{object, X_CO[i], 1.0}};
    }
  }
  return views;
}

std::string SimViewSource::IsolatedSettings() const {
  SensorProfile sensor = options_.sensor;
  AppearanceRanges appearance = options_.appearance;
  return WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); }) +
         WriteSettings([&](SettingsVisitor& v) { appearance.Visit(v); }) +
         fmt::format("color {}\n", options_.color) +
         (options_.isolated_lamps ? "isolated lamps\n" : "");
}

std::string SimViewSource::ClutterSceneSettings() const {
  const ViewSourceOptions& o = options_;
  const CameraIntrinsics& k = o.camera;
  const Eigen::Vector3d& size = o.bin.inner_size_m;
  std::string sensors;
  for (SensorProfile sensor : o.scene_sensors) {
    sensors += WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); });
  }
  for (SensorProfile sensor : o.room_sensors) {
    sensors += "room " + WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); });
  }
  return IsolatedSettings() + sensors +
         fmt::format("camera {}x{} {} {} {} {}\n", k.width(), k.height(), k.fx(), k.fy(), k.cx(),
                     k.cy()) +
         fmt::format("distance {}..{} tilt {} jitter {}\n", o.distance_min_m, o.distance_max_m,
                     o.tilt_max_rad, o.target_jitter_m) +
         fmt::format("bin {} x {} x {} wall {} friction {} mesh {:016x}\n", size.x(), size.y(),
                     size.z(), o.bin.wall_m, o.bin.friction,
                     o.bin.shape ? MeshHash(o.bin.shape->mesh_B) : 0) +
         fmt::format("for {} scaled {} parts {}..{} fill {} mixed {} kinds {}\n", o.for_diameter_m,
                     o.scaled_share, o.instances_min, o.instances_max, o.fill_max, o.mixed_share,
                     o.mixed_kinds_max) +
         (o.deep_share > 0
              ? fmt::format("deep {} parts {}..{} fill {}\n", o.deep_share, o.deep_instances_min,
                            o.deep_instances_max, o.deep_fill_max)
              : "") +
         (o.distractor_share > 0
              ? fmt::format("foreign {} {}\n", o.distractor_share, o.distractor_max)
              : "");
}

// Returns indices into objects_: one kind, or several for a mixed scene. The requested kind is
// first.
std::vector<ObjectId> SimViewSource::RandomKinds(const ClutterSceneRequest& request,
                                                 Rng& rng) const {
  const int kinds = static_cast<int>(objects_.size());
  std::vector<ObjectId> order;
  for (ObjectId object{0}; object < kinds; ++object) order.push_back(object);
  for (int i = kinds - 1; i > 0; --i) std::swap(order[i], order[rng.Index(i + 1)]);
  if (request.object >= 0) {
    std::swap(order.front(), *std::find(order.begin(), order.end(), request.object));
  }
  const int mixed_max = std::min(kinds, options_.mixed_kinds_max);
  const bool mixed = rng.Uniform() < options_.mixed_share && mixed_max > 1;
  order.erase(order.begin() + (mixed ? 2 + rng.Index(mixed_max - 1) : 1), order.end());
  return order;
}

// Returns distractors of about the size of these kinds, as indices into in_scenes_. They use a
// random stream of their own, so a scene without distractors does not depend on `distractor_share`.
std::vector<ObjectId> SimViewSource::RandomDistractor(const ClutterSceneRequest& request,
                                                      const std::vector<ObjectId>& kinds) const {
  constexpr double kRoomShare = 0.7;  // at least, of the rooms
  std::vector<ObjectId> shapes;
  Rng rng = Rng::Derive(request.seed, 0, "pile foreign");
  const bool in_room = IsRoom(request.surroundings);
  const double share =
      in_room ? std::max(kRoomShare, options_.distractor_share) : options_.distractor_share;
  if (in_scenes_.size() == objects_.size() || rng.Uniform() >= share) return shapes;
  const int own = static_cast<int>(objects_.size());
  const int per_object = static_cast<int>(in_scenes_.size()) / own - 1;
  const int count = 1 + rng.Index(options_.distractor_max * (in_room ? 2 : 1));
  for (int i = 0; i < count; ++i) {
    const ObjectId kind = kinds[rng.Index(static_cast<int>(kinds.size()))];
    shapes.push_back(ObjectId(own + kind * per_object + rng.Index(per_object)));
  }
  return shapes;
}

// Returns the number of instances of each object. The first kind gets at least one.
std::vector<int> SimViewSource::RandomCounts(const std::vector<ObjectId>& kinds,
                                             const std::vector<ObjectId>& foreign, const Bin& bin,
                                             bool deep, Rng& rng) const {
  const int min = deep ? options_.deep_instances_min : options_.instances_min;
  const int max = deep ? options_.deep_instances_max : options_.instances_max;
  const int wanted = min + rng.Index(max - min + 1);
  double room_m3 = (deep ? options_.deep_fill_max : options_.fill_max) * bin.inner_size_m.prod();
  std::vector<int> counts(foreign.empty() ? objects_.size() : in_scenes_.size(), 0);
  for (const ObjectId shape : foreign) {
    room_m3 -= BoundingVolume_m3(*in_scenes_[shape]);
    ++counts[shape];
  }
  for (int i = 0; i < wanted; ++i) {
    const ObjectId kind = i == 0 ? kinds.front() : kinds[rng.Index(static_cast<int>(kinds.size()))];
    room_m3 -= BoundingVolume_m3(*objects_[kind]);
    if (i > 0 && room_m3 < 0) break;
    ++counts[kind];
  }
  return counts;
}

double SimViewSource::RandomScale(const ClutterSceneRequest& request,
                                  const std::vector<ObjectId>& kinds, Rng& rng) const {
  const bool scaled = rng.Uniform() < options_.scaled_share || request.typical;
  if (options_.for_diameter_m <= 0 || !scaled) return 1;
  double sum_m = 0;
  for (const ObjectId kind : kinds) sum_m += objects_[kind]->diameter_m;
  return sum_m / static_cast<double>(kinds.size()) / options_.for_diameter_m;
}

SimViewSource::ScaledScene SimViewSource::DropScene(const ClutterSceneRequest& request) const {
  constexpr double kTableShare = 0.5;  // of the empty rooms
  constexpr int kMaxOnTable = 8;       // instances of one kind
  Rng room = Rng::Derive(request.seed, 0, "pile room");
  const bool in_room = IsRoom(request.surroundings);
  const bool is_empty = request.surroundings == Surroundings::kEmptyRoom;
  const bool on_table =
      options_.bin.shape == nullptr && (request.surroundings == Surroundings::kRoomNoBin ||
                                        (is_empty && room.Uniform() < kTableShare));
  for (int attempt = 0; attempt < kSceneAttempts; ++attempt) {
    Rng rng = Rng::Derive(request.seed, attempt, "pile");
    const std::vector<ObjectId> kinds = RandomKinds(request, rng);
    const double scale = RandomScale(request, kinds, rng);
    Bin bin = options_.bin;
    bin.inner_size_m *= scale;
    const std::vector<ObjectId> foreign = RandomDistractor(request, kinds);
    std::vector<int> counts = RandomCounts(kinds, foreign, bin, IsDeep(request) && !on_table, rng);
    for (size_t i = 0; i < objects_.size(); ++i) {
      if (is_empty) counts[i] = 0;
      if (on_table) counts[i] = std::min(counts[i], 1 + room.Index(kMaxOnTable));
    }
    if (on_table) bin.inner_size_m.z() = 0;
    if (is_empty && foreign.empty()) return {{bin, {}}, scale, in_room, on_table};
    DropResult result =
        DropInstances(bin, foreign.empty() ? objects_ : in_scenes_, counts, rng, options_.drop);
    if (!result.certificate.blew_up && (is_empty || !result.scene.objects.empty())) {
      return {std::move(result.scene), scale, in_room, on_table};
    }
  }
  throw std::runtime_error(fmt::format("no settled clutter scene for seed {} in {} attempts",
                                       request.seed, kSceneAttempts));
}

const SensorProfile& SimViewSource::SceneSensor(uint64_t seed, int view) const {
  if (options_.scene_sensors.empty()) return options_.sensor;
  Rng rng = Rng::Derive(seed, view, "pile view sensor");
  return options_.scene_sensors[rng.Index(static_cast<int>(options_.scene_sensors.size()))];
}

// Returns a random profile that sees a scene at this distance, with the failures of real devices.
SensorProfile SimViewSource::RoomSensor(double distance_m, Rng& rng) const {
  constexpr double kNearest = 0.7, kFarthest = 2;  // of the distance, that must be in range
  std::vector<SensorProfile> fitting;
  for (const SensorProfile& sensor : options_.room_sensors) {
    const bool in_range =
        sensor.min_range_m < kNearest * distance_m && sensor.max_range_m > kFarthest * distance_m;
    if (in_range) fitting.push_back(sensor);
  }
  if (fitting.empty()) fitting = options_.scene_sensors;
  if (fitting.empty()) fitting = {options_.sensor};
  return VariedProfile(fitting[rng.Index(static_cast<int>(fitting.size()))], rng);
}

// Adds random surroundings to the instances of a scene, of which the bin is the last.
void SimViewSource::AddRoom(const ScaledScene& clutter_scene, const Camera& camera, Rng& rng,
                            std::vector<RenderInstance>& instances) {
  const double floor_m = options_.bin.inner_size_m.head<2>().norm();
  if (!room_) {
    double mean_m = 0;
    for (const auto& object : objects_) mean_m += object->diameter_m / objects_.size();
    const double scale = options_.for_diameter_m > 0 ? mean_m / options_.for_diameter_m : 1;
    room_ = MakeRoomShapes(objects_, scale * floor_m);
    for (const TriangleMesh* mesh : room_->All()) {
      room_meshes_.push_back(scene_renderer_.renderer().AddMesh(*mesh));
    }
  }
  const Scene& scene = clutter_scene.scene;
  RoomCell cell;
  cell.cell_m = clutter_scene.scale * floor_m;
  cell.support_m = clutter_scene.on_table ? 0 : -scene.bin.wall_m;
  cell.eye_B = camera.X_WC().translation();
  for (const PosedObject& object : scene.objects) {
    const ObjectModel& model = *in_scenes_[object.object];
    cell.kept_free.push_back(
        {object.X_WO * MeshBounds(model.mesh_O).center(), 0.5 * model.diameter_m});
  }
  if (!clutter_scene.on_table) cell.kept_free.push_back({{0, 0, 0}, 0.5 * cell.cell_m});
  const std::vector<PlacedShape> placed = PlaceRoom(*room_, cell, rng);
  if (clutter_scene.on_table && !placed.empty()) instances.pop_back();
  for (const PlacedShape& shape : placed) {
    instances.push_back({room_meshes_[shape.shape], shape.X_BS, 0});
  }
}

Image<float> SimViewSource::Sensed(const ScaledScene& clutter_scene, const RenderedImage& image,
                                   const Camera& camera, uint64_t seed, int view) const {
  Rng noise = Rng::Derive(seed, view, "pile view noise");
  const IdealView ideal{image.depth_m, camera.intrinsics, &image.color};
  if (!clutter_scene.in_room) return ApplySensorNoise(ideal, SceneSensor(seed, view), noise);
  Rng device = Rng::Derive(seed, view, "room sensor");
  const double distance_m = camera.X_WC().translation().norm();
  Image<float> depth_m = ApplySensorNoise(ideal, RoomSensor(distance_m, device), noise);
  ApplyFailures(device, depth_m);
  return depth_m;
}

LabelledView SimViewSource::SceneView(const ScaledScene& clutter_scene, uint64_t seed, int view) {
  const Scene& scene = clutter_scene.scene;
  Rng rng = Rng::Derive(seed, view, "pile camera");
  const Camera camera{options_.camera,
                      RandomCamera(options_, clutter_scene.scale, clutter_scene.in_room, rng)};
  const Light light = RandomLight(options_.appearance, rng);
  std::vector<RenderInstance> instances = scene_renderer_.InstancesOf(scene);
  if (clutter_scene.in_room) {
    Rng room = Rng::Derive(seed, view, "room");
    AddRoom(clutter_scene, camera, room, instances);
  }
  // The material depends on the clutter scene only, so an instance looks the same in all its views.
  for (size_t i = 0; i < instances.size(); ++i) {
    Rng appearance = Rng::Derive(seed, i, "pile looks");
    instances[i].material = RandomMaterial(options_.appearance, appearance);
  }
  RenderOutputs outputs;
  outputs.color = options_.color;
  RenderedImage image = scene_renderer_.renderer().Render(camera, instances, light, outputs);
  Rng background = Rng::Derive(seed, view, "pile background");
  PaintBackground(options_.appearance, background, image);
  const std::vector<double> fractions = scene_renderer_.VisibleFractions(scene, camera, image.ids);

  LabelledView out;
  const Pose X_CW = camera.X_CW();
  int largest = 0;
  for (const PosedObject& object : scene.objects) largest = std::max<int>(largest, object.instance);
  std::vector<uint16_t> new_id(largest + 2, 0);
  for (size_t i = 0; i < scene.objects.size(); ++i) {
    const PosedObject& object = scene.objects[i];
    if (fractions[i] == 0 || IsDistractor(object.object)) continue;
    out.instances.push_back({object.object, X_CW * object.X_WO, fractions[i]});
    new_id[object.instance + 1] = static_cast<uint16_t>(out.instances.size());
  }
  for (uint16_t& id : image.ids.pixels()) id = new_id[id];
  Image<float> depth_m = Sensed(clutter_scene, image, camera, seed, view);
  out.frame = {camera.intrinsics, std::move(image.color), std::move(depth_m)};
  out.ids = std::move(image.ids);
  out.background = KnownBackground{scene.bin, X_CW};  // the bin's frame is the world frame
  return out;
}

std::vector<LabelledView> SimViewSource::ClutterScene(const ClutterSceneRequest& request) {
  CheckInput(request.object >= kAnyObject && request.object < static_cast<int>(objects_.size()),
             fmt::format("object {} of {} does not exist", request.object, objects_.size()));
  const ScaledScene clutter_scene = DropScene(request);
  std::vector<LabelledView> out;
  out.reserve(request.views);
  for (int view = 0; view < request.views; ++view) {
    out.push_back(SceneView(clutter_scene, request.seed, view));
  }
  return out;
}

}  // namespace

std::unique_ptr<LabelledViewSource> MakeSimViewSource(const ObjectSet& objects,
                                                      const ViewSourceOptions& options) {
  CheckInput(!objects.empty(), "no objects for the views; name at least one");
  CheckInput(
      options.instances_min >= 1 && options.instances_max >= options.instances_min,
      fmt::format("{} to {} instances in a clutter scene: need 1 <= instances_min <= instances_max",
                  options.instances_min, options.instances_max));
  CheckInput(options.distance_min_m > 0 && options.distance_max_m >= options.distance_min_m,
             fmt::format("camera distance {} to {} m: need 0 < distance_min_m <= distance_max_m",
                         options.distance_min_m, options.distance_max_m));
  CheckInput(
      options.distractor_share >= 0 && options.distractor_share <= 1 && options.distractor_max >= 1,
      fmt::format("distractors in {} of the clutter scenes, at most {}: need a share of 0 to 1 and "
                  "at least 1 distractor",
                  options.distractor_share, options.distractor_max));
  const bool shares_are_valid = options.mixed_share >= 0 && options.mixed_share <= 1 &&
                                options.scaled_share >= 0 && options.scaled_share <= 1;
  CheckInput(shares_are_valid,
             fmt::format("mixed_share {} and scaled_share {}: both must be from 0 to 1",
                         options.mixed_share, options.scaled_share));
  CheckInput(
      options.deep_share >= 0 && options.deep_share <= 1 && options.deep_fill_max > 0 &&
          options.deep_instances_min >= 1 &&
          options.deep_instances_max >= options.deep_instances_min,
      fmt::format("deep piles in {} of the clutter scenes with {} to {} instances: need a "
                  "share of 0 to 1 and 1 <= deep_instances_min <= deep_instances_max",
                  options.deep_share, options.deep_instances_min, options.deep_instances_max));
  CheckInput(options.mixed_kinds_max >= 1 && options.fill_max > 0,
             fmt::format("mixed_kinds_max {} and fill_max {}: need mixed_kinds_max >= 1 and "
                         "fill_max > 0",
                         options.mixed_kinds_max, options.fill_max));
  CheckInput(options.for_diameter_m <= 0 || options.bin.shape == nullptr,
             "a bin from a mesh cannot be scaled; set for_diameter_m to 0");
  options.appearance.Validate();
  CheckSettings("SensorProfile", options.sensor);
  for (const SensorProfile& sensor : options.scene_sensors) CheckSettings("SensorProfile", sensor);
  for (const SensorProfile& sensor : options.room_sensors) CheckSettings("SensorProfile", sensor);
  CheckSettings("DropOptions", options.drop);
  return std::make_unique<SimViewSource>(objects, options);
}

}  // namespace pickbed::sim
