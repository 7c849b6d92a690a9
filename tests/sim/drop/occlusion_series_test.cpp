#include "sim/drop/occlusion_series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/base/error.h"
#include "sim/drop/occlusion_series.h"
#include "sim/drop/penetration.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using ::testing::HasSubstr;

Camera OverTheBin() {
  Camera camera;
  camera.SetPose(LookAt({0, -0.12, 0.85}, {0, 0, 0.03}, {0, 0, 1}));
  return camera;
}

class OcclusionSeriesTest : public testing::Test {
 protected:
  MadeSeries Make(const std::vector<int>& counts, int trial = 0, uint64_t seed = 3) {
    SceneRenderer renderer(objects_, bin_);
    const OcclusionSetup setup{objects_, counts, OverTheBin(), DropOptions(), spec_};
    return MakeOcclusionSeries(renderer, {bin_, objects_, counts, seed, BinIndex(trial)},
                               {ObjectId{0}, ObjectId{1}, ObjectId{2}, ObjectId{3}}, setup);
  }

  Bin bin_;
  ObjectSet objects_ = MixedObjects();
  OcclusionSpec spec_;
};

// Measures with another renderer than the one that built the series: OpenGL, without coarser levels
// of detail.
double VisibleByOpenGl(const ObjectSet& objects, const Scene& scene, InstanceId instance) {
  Renderer renderer({}, {0, 0}, PlainSurfaces::kOpenGl);
  std::vector<RenderInstance> instances;
  size_t target = 0;
  for (const PosedObject& posed : scene.objects) {
    if (posed.instance == instance) target = instances.size();
    instances.push_back({renderer.AddMesh(objects[posed.object]->mesh_O), posed.X_WO,
                         static_cast<uint16_t>(posed.instance + 1)});
  }
  instances.push_back({renderer.AddMesh(BinMesh(scene.bin)), Pose::Identity(), 0});
  const Camera camera = OverTheBin();
  const auto count = [&](const std::vector<RenderInstance>& drawn) {
    const std::vector<uint16_t> ids = renderer.RenderDepth(camera, drawn).ids.pixels();
    return std::count(ids.begin(), ids.end(), static_cast<uint16_t>(instance + 1));
  };
  return static_cast<double>(count(instances)) / count({instances[target]});
}

bool SamePose(const PosedObject& a, const PosedObject& b) {
  return a.instance == b.instance && a.object == b.object && a.X_WO.matrix() == b.X_WO.matrix();
}

TEST_F(OcclusionSeriesTest, VisibleFractionIsInTheBandOfEachScene) {
  for (const uint64_t trial : {0, 1}) {
    const MadeSeries made = Make({3, 3, 3, 3}, trial);
    ASSERT_EQ(made.series.scenes.size(), spec_.bands.size());
    for (size_t i = 0; i < made.series.scenes.size(); ++i) {
      const OccludedScene& scene = made.series.scenes[i];
      EXPECT_EQ(scene.band, static_cast<int>(spec_.bands.size() - 1 - i));
      const double visible = VisibleByOpenGl(objects_, scene.scene, made.series.target);
      EXPECT_TRUE(spec_.bands[scene.band].Holds(visible)) << visible << " in band " << scene.band;
      EXPECT_NEAR(visible, scene.visible_fraction, spec_.margin);
      EXPECT_EQ(scene.scene.objects.size(), made.start.scene.objects.size() + scene.blockers);
    }
  }
}

// Mean position of the fractions in their bands: 0 at the lower limit, 1 at the upper. In the start
// scene of a series the target is mostly visible.
TEST_F(OcclusionSeriesTest, FractionsAreDistributedOverTheBands) {
  const auto mean_position = [&](int level_samples, int from_band) {
    spec_.level_samples = level_samples;
    double sum = 0;
    int scenes = 0;
    for (uint64_t trial = 0; trial < 8; ++trial) {
      for (const OccludedScene& scene : Make({3, 3, 3, 3}, trial).series.scenes) {
        if (scene.band < from_band) continue;
        const VisibleBand band = spec_.Inner(scene.band);
        const double position = (scene.visible_fraction - band.min) / (band.max - band.min);
        EXPECT_GE(position, 0);
        EXPECT_LE(position, 1);
        sum += position;
        ++scenes;
      }
    }
    return sum / scenes;
  };
  const int top = static_cast<int>(spec_.bands.size()) - 1;
  EXPECT_GT(mean_position(0, top), 0.9) << "the first scene is kept";
  EXPECT_LT(mean_position(20, top), 0.85);
  EXPECT_NEAR(mean_position(6, 0), 0.5, 0.15);
}

// Instances that were there before a blocker, above all the target, keep their poses exactly.
TEST_F(OcclusionSeriesTest, InstancesKeepTheirPosesWhileABlockerSettles) {
  const MadeSeries made = Make({3, 3, 3, 3});
  ASSERT_FALSE(made.series.scenes.empty());
  const std::vector<PosedObject>* before = &made.start.scene.objects;
  for (const OccludedScene& scene : made.series.scenes) {
    const std::vector<PosedObject>& after = scene.scene.objects;
    ASSERT_GE(after.size(), before->size());
    for (size_t i = 0; i < before->size(); ++i) EXPECT_TRUE(SamePose((*before)[i], after[i])) << i;
    before = &after;
  }
}

TEST_F(OcclusionSeriesTest, EachSceneStaysAtRestWhenAllAreAwake) {
  const MadeSeries made = Make({3, 3, 3, 3});
  ASSERT_FALSE(made.series.scenes.empty());
  for (const OccludedScene& scene : made.series.scenes) {
    EXPECT_THAT(Faults(scene.certificate), testing::IsEmpty());
    EXPECT_LE(scene.certificate.wake_movement_diameters, spec_.movement_diameters);
    EXPECT_LT(DeepestPenetration(scene.scene, objects_), 0.0005);
    PhysicsWorld world(PhysicsFor(objects_, DropOptions().physics));  // as used to settle scenes
    world.AddBin(bin_);
    for (const PosedObject& posed : scene.scene.objects) {
      world.AddInstance(*objects_[posed.object], posed.X_WO);
    }
    world.ForbidSleep();
    while (world.time_s() < 1) world.Step();
    for (size_t i = 0; i < scene.scene.objects.size(); ++i) {
      const PosedObject& posed = scene.scene.objects[i];
      const ObjectModel& object = *objects_[posed.object];
      const Eigen::Vector3d moved_m =
          world.X_WO(static_cast<int>(i)) * object.mass.com_O - posed.X_WO * object.mass.com_O;
      EXPECT_LT(moved_m.norm(), spec_.movement_diameters * object.diameter_m) << "instance " << i;
    }
  }
}

TEST_F(OcclusionSeriesTest, DependsOnlyOnSeedAndTrial) {
  const auto same = [](const MadeSeries& a, const MadeSeries& b) {
    if (a.series.target != b.series.target) return false;
    const Scene &last_a = a.series.scenes.back().scene, &last_b = b.series.scenes.back().scene;
    return std::equal(last_a.objects.begin(), last_a.objects.end(), last_b.objects.begin(),
                      last_b.objects.end(), SamePose);
  };
  const MadeSeries first = Make({2, 2, 2, 2}, 4);
  EXPECT_TRUE(same(first, Make({2, 2, 2, 2}, 4)));
  EXPECT_FALSE(same(first, Make({2, 2, 2, 2}, 5)));
  EXPECT_FALSE(same(first, Make({2, 2, 2, 2}, 4, 8)));
}

TEST_F(OcclusionSeriesTest, EveryDroppedBlockerIsCounted) {
  int refused = 0;
  for (const uint64_t trial : {0, 1, 2}) {
    const MadeSeries made = Make({3, 3, 3, 3}, trial);
    BlockerCounts sum;
    for (const BandAccount& band : made.bands) sum.Add(band.blockers);
    EXPECT_EQ(sum.dropped, sum.kept + sum.refused + sum.jumped + sum.useless);
    EXPECT_GE(sum.kept, made.series.scenes.back().blockers);
    refused += sum.refused;
  }
  EXPECT_GT(refused, 0) << "the case did not occur";
}

// A plate of 60 x 80 mm is upright on its edge of 5 mm. A blocker that leans on the frozen plate
// overturns it when the plate wakes.
TEST(OccludeTarget, BlockerThatOverturnsTheTargetIsRemoved) {
  const ObjectSet objects{BoxObject({0.06, 0.005, 0.08}, 0.05), BoxObject({0.16, 0.02, 0.02}, 0.3)};
  Scene scene;
  scene.objects = {{InstanceId{0}, ObjectId{0}, Translation({0, 0, 0.04})}};
  const SceneCertificate standing = CertifyRest(scene, objects);
  ASSERT_THAT(Faults(standing), testing::IsEmpty()) << "the plate does not stay upright";
  OcclusionSetup setup{objects, {0, 1}, {}, DropOptions(), {}};
  setup.camera.SetPose(LookAt({0, -0.6, 0.6}, {0, 0, 0.04}, {0, 0, 1}));
  setup.spec.blocker_samples = 40;
  SceneRenderer renderer(objects, scene.bin);
  Rng rng(5);
  const OcclusionSeries series =
      OccludeTarget(renderer, {scene, standing}, InstanceId{0}, setup, rng);
  BlockerCounts sum;
  for (const BlockerCounts& counts : series.blockers) sum.Add(counts);
  EXPECT_GT(sum.refused, 0);
  for (const OccludedScene& occluded : series.scenes) {
    EXPECT_LE(CertifyRest(occluded.scene, objects).wake_movement_diameters,
              setup.spec.movement_diameters);
  }
}

// A plate over a cube hides the cube completely or not at all.
TEST(OccludeTarget, BlockerThatSkipsABandIsRemoved) {
  const ObjectSet objects{BoxObject({0.03, 0.03, 0.03}, 0.1), BoxObject({0.2, 0.2, 0.01}, 0.4)};
  Scene scene;
  scene.objects = {{InstanceId{0}, ObjectId{0}, Translation({0, 0, 0.015})}};
  OcclusionSetup setup{objects, {0, 1}, OverTheBin(), DropOptions(), {}};
  setup.spec.bands = {{0.45, 0.47}, {0.9, 1}};
  setup.spec.blocker_samples = 12;
  setup.spec.scatter_diameters = 0;
  SceneRenderer renderer(objects, scene.bin);
  Rng rng(5);
  const OcclusionSeries series =
      OccludeTarget(renderer, {scene, CertifyRest(scene, objects)}, InstanceId{0}, setup, rng);
  ASSERT_EQ(series.scenes.size(), 1u);
  EXPECT_EQ(series.scenes[0].band, 1);
  EXPECT_EQ(series.scenes[0].blockers, 0);
  EXPECT_GT(series.blockers[0].jumped, 0);
  EXPECT_EQ(series.blockers[0].dropped, 12);
  EXPECT_EQ(series.blockers[0].kept, 0);
}

TEST_F(OcclusionSeriesTest, UnfillableBandDoesNotAffectTheOthers) {
  spec_.bands = {{0.300, 0.302}, {0.5, 0.7}, {0.9, 1}};
  spec_.margin = 0;
  spec_.blocker_samples = 3;
  spec_.targets = 2;
  spec_.scenes = 2;
  const MadeSeries made = Make({1, 1, 1, 1});
  EXPECT_EQ(made.targets_tried, 4) << "the number of targets tried before the band is given up";
  EXPECT_EQ(made.bands[0].given_up + made.bands[1].given_up, 4);
  EXPECT_FALSE(made.bands[0].filled);
  EXPECT_TRUE(made.bands[2].filled);
}

TEST_F(OcclusionSeriesTest, SingleInstanceIsHiddenByItsOwnObject) {
  const MadeSeries made = Make({1, 0, 0, 0});
  EXPECT_EQ(made.series.scenes.size(), spec_.bands.size());
  EXPECT_EQ(made.series.target, 0);
}

TEST_F(OcclusionSeriesTest, CountsAreKeptIfNoBandIsFilled) {
  spec_.bands = {{0.500, 0.502}};
  spec_.margin = 0;
  spec_.blocker_samples = 2;
  spec_.targets = spec_.scenes = 1;
  const MadeSeries made = Make({1, 1, 0, 0}, 7);
  EXPECT_THAT(made.series.scenes, testing::IsEmpty());
  EXPECT_EQ(made.targets_tried, 1);
  EXPECT_EQ(made.bands, (std::vector<BandAccount>{{false, 1, made.bands[0].blockers}}));
  EXPECT_EQ(made.bands[0].blockers.dropped, 2);
  EXPECT_EQ(made.start.scene.objects.size(), 2u) << "the start scene of the attempt is kept";
}

TEST_F(OcclusionSeriesTest, NoBandIsFilledIfNoInstanceIsInView) {
  SceneRenderer renderer(objects_, bin_);
  OcclusionSetup setup{objects_, {2, 0, 0, 0}, {}, DropOptions(), OcclusionSpec{}};
  setup.camera.SetPose(LookAt({0, -0.8, 0.15}, {0, 0, 0.14}, {0, 0, 1}));  // above the rim
  const SceneRequest request{bin_, objects_, {2, 0, 0, 0}, 1, BinIndex(2)};
  const MadeSeries made = MakeOcclusionSeries(renderer, request, {ObjectId{0}}, setup);
  EXPECT_EQ(made.bands, std::vector<BandAccount>(5));
  EXPECT_EQ(made.targets_tried, 0);
  EXPECT_THAT(ErrorOf([&] { MakeOcclusionSeries(renderer, request, {ObjectId{1}}, setup); }),
              HasSubstr("no object that can be its target"));
}

TEST_F(OcclusionSeriesTest, RefusedScenesAreKeptIfNoneComesToRest) {
  bin_.inner_size_m = {0.1, 0.1, 0.02};
  spec_.scenes = 2;
  const MadeSeries made = Make({30, 0, 0, 0});
  EXPECT_TRUE(made.start.scene.objects.empty());
  EXPECT_EQ(made.bands, std::vector<BandAccount>(5));
  ASSERT_EQ(made.start.refused.size(), 20u) << "the attempts of both scenes are listed";
  EXPECT_EQ(made.start.refused.back().attempt, 19);
}

// Overlapping instances and instances in the air do not stay at rest.
TEST(CertifyRest, FindsInstancesThatDoNotStayAtRest) {
  const ObjectSet objects{BoxObject({0.04, 0.04, 0.04}, 0.1)};
  const auto faults = [&](const std::vector<Pose>& poses) {
    Scene scene;
    for (const Pose& X_WO : poses) {
      scene.objects.push_back({InstanceId(scene.objects.size()), ObjectId{0}, X_WO});
    }
    return Faults(CertifyRest(scene, objects));
  };
  const Pose resting = Translation({0, 0, 0.0205});  // above the margin of the hulls
  EXPECT_THAT(faults({resting}), testing::IsEmpty());
  EXPECT_THAT(faults({resting, Translation({0, 0, 0.0615})}), testing::IsEmpty());
  EXPECT_THAT(faults({Translation({0, 0, 0.05})}), testing::Contains(HasSubstr("not at rest")));
  EXPECT_THAT(faults({resting, Translation({0.03, 0, 0.0205})}),
              testing::Contains(HasSubstr("two bodies overlap")));
  EXPECT_THAT(faults({resting, Translation({0.025, 0, 0.0615})}),
              testing::Contains(HasSubstr("not at rest")))
      << "its center of mass is beyond the edge";
  EXPECT_THAT(faults({Translation({0.5, 0, 0.02})}),
              testing::Contains(HasSubstr("1 instance fell outside")));
}

}  // namespace
}  // namespace pickbed::tests
