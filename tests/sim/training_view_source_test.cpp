#include "sim/training_view_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "scenes/base/error.h"
#include "scenes/geometry/mesh_query.h"
#include "scenes/part_families/part_families.h"
#include "tests/sim/render_support.h"
#include "tests/support/tapered_bin.h"

namespace pickbed::tests {
namespace {

ObjectSet FirstObjects(int count) {
  ObjectSet objects;
  for (const FamilyRow& row : FamilyTable().first(count)) {
    const FamilyObject object = row.make();
    auto model = std::make_shared<ObjectModel>();
    model->name = row.name;
    model->mesh_O = object.mesh_O;
    model->convex_pieces_O = object.convex_pieces_O;
    model->friction = object.friction;
    model->mass = UniformMassProperties(object.mesh_O, 0.05);
    model->diameter_m = Diameter(object.mesh_O);
    objects.push_back(model);
  }
  return objects;
}

ViewSourceOptions SmallOptions() {
  ViewSourceOptions options;
  options.camera = {320, 240, 340, 340, 159.5, 119.5};
  options.instances_min = 4;
  options.instances_max = 8;
  options.sensor.random_dropout = 0.004;
  options.sensor.axial_sigma_m = 0.001;
  return options;
}

std::vector<Pose> SomePoses(int count) {
  Rng rng(1);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    poses.push_back(MakePose(rng.Rotation().toRotationMatrix(),
                             {rng.Uniform(-0.01, 0.01), rng.Uniform(-0.01, 0.01), 0.8}));
  }
  return poses;
}

TEST(ViewSource, IsolatedViewsMatchTheMeshAtTheGivenPoses) {
  const ObjectSet objects = FirstObjects(2);
  ViewSourceOptions options = SmallOptions();
  options.sensor = SensorProfile();
  const auto source = MakeSimViewSource(objects, options);
  // A crop of a larger image: its principal point is not in the center.
  const CameraIntrinsics crop{96, 80, 680, 690, 45.0, 41.0};
  const std::vector<Pose> X_CO = SomePoses(20);
  const std::vector<LabelledView> views = source->Isolated(ObjectId{1}, X_CO, crop, 7);
  ASSERT_EQ(views.size(), X_CO.size());
  const MeshQuery query(objects[1]->mesh_O);
  for (size_t i = 0; i < views.size(); ++i) {
    const LabelledView& view = views[i];
    EXPECT_EQ(view.frame.intrinsics, crop);
    EXPECT_EQ(view.frame.color.size(), view.frame.depth_m.size());
    EXPECT_FALSE(view.background.has_value());
    ASSERT_EQ(view.instances.size(), 1u);
    EXPECT_EQ(view.instances[0].object, 1);
    EXPECT_TRUE(view.instances[0].X_CO.isApprox(X_CO[i]));
    EXPECT_EQ(view.instances[0].visible_fraction, 1.0);
    int covered = 0;
    for (int v = 0; v < crop.height(); ++v) {
      for (int u = 0; u < crop.width(); ++u) {
        const double z = view.frame.depth_m(u, v);
        ASSERT_EQ(view.ids(u, v), z > 0 ? 1 : 0);
        if (z == 0) continue;
        ++covered;
        const Eigen::Vector3d p_O = X_CO[i].inverse() * BackProject(crop, u, v, z);
        // The level of detail deviates by up to a quarter of a pixel.
        EXPECT_LT(query.ClosestPoint(p_O).distance, 4e-4);
      }
    }
    EXPECT_GT(covered, 200);
  }
}

TEST(ViewSource, IsolatedNoiseDependsOnViewAndSeed) {
  const auto source = MakeSimViewSource(FirstObjects(1), SmallOptions());
  const CameraIntrinsics camera{64, 64, 500, 500, 31.5, 31.5};
  const std::vector<Pose> pose = SomePoses(1), poses(3, pose[0]);
  const auto a = source->Isolated(ObjectId{0}, poses, camera, 1);
  const auto b = source->Isolated(ObjectId{0}, poses, camera, 1);
  const auto c = source->Isolated(ObjectId{0}, poses, camera, 2);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(a[i].frame.depth_m, b[i].frame.depth_m);
    EXPECT_NE(a[i].frame.depth_m, c[i].frame.depth_m);
  }
  EXPECT_NE(a[0].frame.depth_m, a[1].frame.depth_m);
  const auto single = source->Isolated(ObjectId{0}, pose, camera, 1);
  for (size_t p = 0; p < single[0].frame.depth_m.size(); ++p) {
    EXPECT_NEAR(single[0].frame.depth_m.data()[p], a[0].frame.depth_m.data()[p], 1e-5);
  }
}

TEST(ViewSource, ColorIsOptional) {
  ViewSourceOptions options = SmallOptions();
  options.color = false;
  const auto source = MakeSimViewSource(FirstObjects(1), options);
  const auto views = source->Isolated(ObjectId{0}, SomePoses(2), {64, 64, 500, 500, 31.5, 31.5}, 1);
  EXPECT_TRUE(views[0].frame.color.empty());
  EXPECT_FALSE(views[0].frame.depth_m.empty());
  EXPECT_TRUE(source->ClutterScene({1, 1})[0].frame.color.empty());
}

// Every reading of an instance is on its mesh at its pose, and every background reading is on the
// given bin. So ids, poses, depth and camera are consistent.
TEST(ViewSource, SceneLabelsAgreeWithDepth) {
  const ObjectSet objects = FirstObjects(3);
  ViewSourceOptions options = SmallOptions();
  options.sensor = SensorProfile();
  const auto source = MakeSimViewSource(objects, options);
  std::vector<MeshQuery> queries;
  for (const auto& object : objects) queries.emplace_back(object->mesh_O);
  const MeshQuery bin(BinMesh(options.bin));
  for (const LabelledView& view : source->ClutterScene({3, 2})) {
    EXPECT_EQ(view.frame.intrinsics, options.camera);
    ASSERT_TRUE(view.background.has_value());
    ASSERT_FALSE(view.instances.empty());
    std::vector<int> pixels(view.instances.size(), 0);
    for (int v = 0; v < view.ids.height(); ++v) {
      for (int u = 0; u < view.ids.width(); ++u) {
        const int id = view.ids(u, v);
        const double z = view.frame.depth_m(u, v);
        if (z == 0) {
          EXPECT_EQ(id, 0);
          continue;
        }
        const Eigen::Vector3d p_C = BackProject(view.frame.intrinsics, u, v, z);
        if (id == 0) {
          ASSERT_LT(bin.ClosestPoint(view.background->X_CB.inverse() * p_C).distance, 1e-4);
          continue;
        }
        ASSERT_LE(id, static_cast<int>(view.instances.size()));
        const LabelledInstance& instance = view.instances[id - 1];
        ASSERT_LT(queries[instance.object].ClosestPoint(instance.X_CO.inverse() * p_C).distance,
                  1e-3);
        ++pixels[id - 1];
      }
    }
    for (size_t i = 0; i < pixels.size(); ++i) {
      EXPECT_GT(pixels[i], 0);
      EXPECT_GT(view.instances[i].visible_fraction, 0);
      EXPECT_LE(view.instances[i].visible_fraction, 1);
    }
  }
}

TEST(ViewSource, SceneDependsOnlyOnTheSeed) {
  const ObjectSet objects = FirstObjects(3);
  const auto source = MakeSimViewSource(objects, SmallOptions());
  const auto other_source = MakeSimViewSource(objects, SmallOptions());
  const auto a = source->ClutterScene({5, 1});
  source->ClutterScene({6, 1});
  for (const auto& b : {source->ClutterScene({5, 1}), other_source->ClutterScene({5, 1})}) {
    EXPECT_EQ(a[0].frame.depth_m, b[0].frame.depth_m);
    EXPECT_EQ(a[0].frame.color, b[0].frame.color);
    EXPECT_EQ(a[0].ids, b[0].ids);
  }
  EXPECT_NE(a[0].ids, source->ClutterScene({6, 1})[0].ids);
}

TEST(ViewSource, ScenesOfOneObjectAndMixedScenesOccur) {
  const auto source = MakeSimViewSource(FirstObjects(4), SmallOptions());
  std::map<int, int> by_object_count;
  for (uint64_t seed = 0; seed < 16; ++seed) {
    std::set<int> drawn;
    const auto views = source->ClutterScene({seed, 1});
    for (const LabelledInstance& instance : views[0].instances) drawn.insert(instance.object);
    ++by_object_count[std::min<int>(2, static_cast<int>(drawn.size()))];
  }
  EXPECT_GT(by_object_count[1], 2);
  EXPECT_GT(by_object_count[2], 2);
}

TEST(ViewSource, CameraPosesStayInTheirLimits) {
  const ViewSourceOptions options = SmallOptions();
  const auto source = MakeSimViewSource(FirstObjects(1), options);
  double min_m = 10, max_m = 0;
  for (const LabelledView& view : source->ClutterScene({1, 40})) {
    const Pose X_BC = view.background->X_CB.inverse();
    const Eigen::Vector3d axis_B = X_BC.linear().col(2);
    EXPECT_GE(-axis_B.z(), std::cos(options.tilt_max_rad) - 1e-9);
    // The point where the optical axis meets the floor.
    const double distance_m = X_BC.translation().z() / -axis_B.z();
    const Eigen::Vector3d target_B = X_BC.translation() + distance_m * axis_B;
    EXPECT_LE(target_B.head<2>().cwiseAbs().maxCoeff(), options.target_jitter_m + 1e-9);
    min_m = std::min(min_m, distance_m);
    max_m = std::max(max_m, distance_m);
  }
  EXPECT_GE(min_m, options.distance_min_m - 1e-9);
  EXPECT_LE(max_m, options.distance_max_m + 1e-9);
  EXPECT_GT(max_m - min_m, 0.5 * (options.distance_max_m - options.distance_min_m));
}

TEST(ViewSource, FillLimitsTheInstanceCount) {
  ViewSourceOptions options = SmallOptions();
  options.instances_min = options.instances_max = 30;
  const ObjectSet objects = FirstObjects(1);
  const double object_m3 = MeshBounds(objects[0]->mesh_O).size().prod();
  options.fill_max = 5.5 * object_m3 / options.bin.inner_size_m.prod();
  EXPECT_LE(MakeSimViewSource(objects, options)->ClutterScene({1, 1})[0].instances.size(), 5u);
}

TEST(ViewSource, AppearanceChangesColorButNotDepth) {
  const ObjectSet objects = FirstObjects(2);
  ViewSourceOptions options = SmallOptions();
  const auto plain = MakeSimViewSource(objects, options)->ClutterScene({5, 2});
  options.appearance = WideAppearance();
  const auto wide = MakeSimViewSource(objects, options);
  const auto a = wide->ClutterScene({5, 2}), b = wide->ClutterScene({5, 2});
  for (int view = 0; view < 2; ++view) {
    EXPECT_EQ(a[view].frame.color, b[view].frame.color);
    EXPECT_NE(a[view].frame.color, plain[view].frame.color);
    size_t same = 0;
    for (size_t i = 0; i < a[view].ids.size(); ++i) {
      const float z = a[view].frame.depth_m.data()[i], w = plain[view].frame.depth_m.data()[i];
      same += std::abs(z - w) < 1e-5 && a[view].ids.data()[i] == plain[view].ids.data()[i];
    }
    EXPECT_GE(same, 0.999 * a[view].ids.size());
  }
  const CameraIntrinsics crop{64, 64, 500, 500, 31.5, 31.5};
  const auto one = wide->Isolated(ObjectId{0}, SomePoses(2), crop, 1);
  const auto other = wide->Isolated(ObjectId{0}, SomePoses(2), crop, 2);
  EXPECT_EQ(one[0].frame.color, wide->Isolated(ObjectId{0}, SomePoses(2), crop, 1)[0].frame.color);
  EXPECT_NE(one[0].frame.color, other[0].frame.color);
  options.appearance.tint = {0.9, 0.2};
  try {
    MakeSimViewSource(objects, options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("tint = [0.9, 0.2]"), std::string::npos);
  }
}

// Scene views come from each of the given sensors, and from no other.
TEST(ViewSource, ScenesAreSeenByAllSceneSensors) {
  const ObjectSet objects = FirstObjects(1);
  ViewSourceOptions options = SmallOptions();
  const auto views_of = [&](const SensorProfile& sensor) {
    options.sensor = sensor;
    return MakeSimViewSource(objects, options)->ClutterScene({5, 12});
  };
  SensorProfile blind;
  blind.random_dropout = 1;
  const auto clear = views_of({}), none = views_of(blind);
  options.scene_sensors = {{}, blind};
  const auto mixed = views_of(blind);
  int seen = 0;
  for (size_t i = 0; i < mixed.size(); ++i) {
    const bool is_clear = mixed[i].frame.depth_m == clear[i].frame.depth_m;
    EXPECT_NE(is_clear, mixed[i].frame.depth_m == none[i].frame.depth_m);
    seen += is_clear;
  }
  EXPECT_GT(seen, 0);
  EXPECT_LT(seen, 12);
}

// Returns the number of pixels without an instance id that show a surface inside the bin, above its
// floor.
int UnlabelledPixels(const LabelledView& view) {
  const Pose X_BC = view.background->X_CB.inverse();
  const Eigen::Vector3d half_m = 0.5 * view.background->bin.inner_size_m;
  int count = 0;
  for (int v = 0; v < view.ids.height(); ++v) {
    for (int u = 0; u < view.ids.width(); ++u) {
      const float z_m = view.frame.depth_m(u, v);
      if (z_m == 0 || view.ids(u, v) != 0) continue;
      const Eigen::Vector3d p_B = X_BC * BackProject(view.frame.intrinsics, u, v, z_m);
      count += p_B.z() > 0.012 && std::abs(p_B.x()) < half_m.x() - 0.01 &&
               std::abs(p_B.y()) < half_m.y() - 0.01;
    }
  }
  return count;
}

TEST(ViewSource, DistractorsAreInScenesAndAreBackground) {
  const ObjectSet objects = FirstObjects(2);
  ViewSourceOptions options = SmallOptions();
  options.sensor = SensorProfile();
  const auto none = MakeSimViewSource(objects, options);
  options.distractor_share = 0.5;
  const auto half = MakeSimViewSource(objects, options);
  EXPECT_NE(none->ClutterSceneSettings(), half->ClutterSceneSettings());
  EXPECT_EQ(none->IsolatedSettings(), half->IsolatedSettings());
  int scenes_with_distractors = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    const LabelledView view = half->ClutterScene({seed, 1}).front(),
                       plain = none->ClutterScene({seed, 1}).front();
    EXPECT_EQ(UnlabelledPixels(plain), 0);
    const int unlabelled = UnlabelledPixels(view);
    EXPECT_EQ(unlabelled == 0, view.frame.depth_m == plain.frame.depth_m);
    scenes_with_distractors += unlabelled > 0;
    for (const LabelledInstance& instance : view.instances) EXPECT_LT(instance.object, 2);
  }
  EXPECT_GE(scenes_with_distractors, 3);
  EXPECT_LE(scenes_with_distractors, 9);
}

// A cell for objects of half the size is half as large, both camera distance and bin. The requested
// object is the only one in the scene.
TEST(ViewSource, CellScalesWithTheObject) {
  const ObjectSet objects = FirstObjects(3);
  ViewSourceOptions options = SmallOptions();
  options.mixed_share = 0;
  const auto plain = MakeSimViewSource(objects, options);
  options.for_diameter_m = 2 * objects[1]->diameter_m;
  const auto scaled = MakeSimViewSource(objects, options);
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const ClutterSceneRequest request{seed, 1, ObjectId{1}, true};
    const LabelledView view = scaled->ClutterScene(request).front();
    for (const LabelledInstance& instance : view.instances) EXPECT_EQ(instance.object, 1);
    EXPECT_NEAR(view.background->bin.inner_size_m.x(), 0.5 * options.bin.inner_size_m.x(), 1e-12);
    const double distance_m = view.background->X_CB.translation().norm();
    EXPECT_LE(distance_m, 0.5 * (options.distance_max_m + 2 * options.target_jitter_m));
    EXPECT_GE(distance_m, 0.5 * (options.distance_min_m - 2 * options.target_jitter_m));
    EXPECT_EQ(plain->ClutterScene(request).front().background->bin.inner_size_m,
              options.bin.inner_size_m);
  }
  EXPECT_THROW(scaled->ClutterScene({0, 1, ObjectId{3}}), InputError);
}

// A room shows surfaces outside of the bin, also without any instance. Instances keep their labels,
// and other scenes do not depend on the sensors of rooms.
TEST(ViewSource, RoomsSurroundTheBinAndMayBeEmpty) {
  const ObjectSet objects = FirstObjects(1);
  ViewSourceOptions options = SmallOptions();
  options.sensor = SensorProfile();
  options.color = false;
  const auto source = MakeSimViewSource(objects, options);
  const auto share_with_depth = [](const LabelledView& view) {
    int count = 0;
    for (const float z_m : view.frame.depth_m.pixels()) count += z_m > 0;
    return static_cast<double>(count) / view.frame.depth_m.size();
  };
  const ClutterSceneRequest plain{5, 1};
  for (const auto surroundings :
       {Surroundings::kRoomAndBin, Surroundings::kRoomNoBin, Surroundings::kEmptyRoom}) {
    ClutterSceneRequest request = plain;
    request.surroundings = surroundings;
    double seen = 0;
    int labelled = 0;
    for (uint64_t seed = 0; seed < 4; ++seed) {
      request.seed = seed;
      const LabelledView view = source->ClutterScene(request).front();
      ASSERT_TRUE(view.background.has_value());
      seen += share_with_depth(view) / 4;
      for (const uint16_t id : view.ids.pixels()) labelled += id > 0;
      EXPECT_EQ(view.instances.empty(), surroundings == Surroundings::kEmptyRoom);
    }
    EXPECT_GT(seen, 0.6);
    EXPECT_EQ(labelled > 0, surroundings != Surroundings::kEmptyRoom);
    EXPECT_EQ(source->ClutterScene(request).front().frame.depth_m,
              source->ClutterScene(request).front().frame.depth_m);
  }
  ViewSourceOptions with_sensor = options;
  with_sensor.room_sensors = {LoadSensorProfile("kinect_v1")};
  const auto noisy = MakeSimViewSource(objects, with_sensor);
  EXPECT_NE(source->ClutterSceneSettings(), noisy->ClutterSceneSettings());
  EXPECT_EQ(source->ClutterScene(plain).front().frame.depth_m,
            noisy->ClutterScene(plain).front().frame.depth_m);
}

TEST(ViewSource, SettingsDifferForDifferentViews) {
  const ObjectSet objects = FirstObjects(1);
  const ViewSourceOptions options = SmallOptions();
  const auto source = MakeSimViewSource(objects, options);
  EXPECT_EQ(source->ClutterSceneSettings(),
            MakeSimViewSource(objects, options)->ClutterSceneSettings());
  ViewSourceOptions noisier = options;
  noisier.sensor.axial_sigma_m += 0.001;
  const auto other_sensor = MakeSimViewSource(objects, noisier);
  EXPECT_NE(source->IsolatedSettings(), other_sensor->IsolatedSettings());
  EXPECT_NE(source->ClutterSceneSettings(), other_sensor->ClutterSceneSettings());
  ViewSourceOptions several = options;
  several.scene_sensors = {options.sensor, noisier.sensor};
  const auto other_sensors = MakeSimViewSource(objects, several);
  EXPECT_EQ(source->IsolatedSettings(), other_sensors->IsolatedSettings());
  EXPECT_NE(source->ClutterSceneSettings(), other_sensors->ClutterSceneSettings());
  ViewSourceOptions appearance = options;
  appearance.appearance = WideAppearance();
  EXPECT_NE(source->IsolatedSettings(), MakeSimViewSource(objects, appearance)->IsolatedSettings());
  ViewSourceOptions deeper = options;
  deeper.bin.inner_size_m.z() += 0.01;
  const auto other_bin = MakeSimViewSource(objects, deeper);
  EXPECT_EQ(source->IsolatedSettings(), other_bin->IsolatedSettings());
  EXPECT_NE(source->ClutterSceneSettings(), other_bin->ClutterSceneSettings());
}

TEST(ViewSource, InvalidInputIsRefused) {
  EXPECT_THROW(MakeSimViewSource({}, SmallOptions()), InputError);
  ViewSourceOptions options = SmallOptions();
  options.instances_max = 2;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  options = SmallOptions();
  options.distance_min_m = 2;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  options = SmallOptions();
  options.distractor_share = 1.5;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  options = SmallOptions();
  options.mixed_share = -0.1;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  options = SmallOptions();
  options.fill_max = 0;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  options = SmallOptions();
  options.bin.shape = std::make_shared<BinShape>(MakeBinShape(TaperedBin(), "bin"));
  EXPECT_NO_THROW(MakeSimViewSource(FirstObjects(1), options));
  options.for_diameter_m = 0.05;
  EXPECT_THROW(MakeSimViewSource(FirstObjects(1), options), InputError);
  const auto source = MakeSimViewSource(FirstObjects(1), SmallOptions());
  EXPECT_THROW(source->ClutterScene({0, 1, ObjectId{-2}}), InputError);
  EXPECT_THROW(source->Isolated(ObjectId{1}, SomePoses(1), {}, 0), InputError);
}

}  // namespace
}  // namespace pickbed::tests
