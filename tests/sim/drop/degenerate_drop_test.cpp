// Placement, overlap, movement and fill level of objects without extent, without pieces or with
// flat ones.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scenes/base/error.h"
#include "sim/drop/certified_scene.h"
#include "sim/drop/distractors.h"
#include "sim/drop/drop_layout.h"
#include "sim/drop/fill_level.h"
#include "sim/drop/penetration.h"
#include "sim/drop/resting_poses.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/sim/physics_objects.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

const Bin kWideBin{{0.4, 0.2, 0.1}};
const Bin kNoFloor{{0, 0, 0}};

std::shared_ptr<const ObjectModel> ObjectOfPoints(std::vector<Vector3d> points) {
  auto model = std::make_shared<ObjectModel>();
  model->name = "thing";
  model->mesh_O.vertices = points;
  model->diameter_m = Diameter(model->mesh_O);
  if (!points.empty()) model->convex_pieces_O = {{std::move(points)}};
  return model;
}

const Vector3d kPoint(0.01, 0.02, 0.03);
// 100 x 20 mm, without thickness.
const std::vector<Vector3d> kPlate{{0, 0, 0}, {0.1, 0, 0}, {0, 0.02, 0}, {0.1, 0.02, 0}};

ObjectSet FlatObjects() {
  return {ObjectOfPoints({kPoint}), ObjectOfPoints(std::vector<Vector3d>(8, kPoint)),
          ObjectOfPoints({{0, 0, 0}, {0.05, 0, 0}, {0.1, 0, 0}}), ObjectOfPoints(kPlate)};
}

TEST(DegenerateLayout, BoxesOfFlatObjectsAreExact) {
  const Matrix3d quarter =
      Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_TRUE(RotatedBox(*ObjectOfPoints({}), quarter).isEmpty());
  for (const auto& object : {ObjectOfPoints({kPoint}), ObjectOfPoints({kPoint, kPoint, kPoint})}) {
    const Eigen::AlignedBox3d box = RotatedBox(*object, quarter);
    EXPECT_LT((box.min() - Vector3d(-0.02, 0.01, 0.03)).norm(), 1e-12);
    EXPECT_EQ(box.sizes(), Vector3d::Zero());
  }
  const Vector3d size = RotatedBox(*ObjectOfPoints(kPlate), quarter).sizes();
  EXPECT_LT((size - Vector3d(0.02, 0.1, 0)).norm(), 1e-12);
}

TEST(DegenerateLayout, FlatObjectsFitUpToTheSizeOfTheFloor) {
  for (const auto& object : FlatObjects()) EXPECT_NO_THROW(RequireFits(*object, kWideBin));
  EXPECT_NO_THROW(RequireFits(*ObjectOfPoints({kPoint}), kNoFloor));
  EXPECT_NO_THROW(RequireFits(*ObjectOfPoints(kPlate), {{0.1, 0.02, 0}}));
  for (const Bin& bin : {Bin{{0.099, 0.02, 1}}, Bin{{0.1, 0.019, 1}}, kNoFloor}) {
    EXPECT_THAT(ErrorOf([&] { RequireFits(*ObjectOfPoints(kPlate), bin); }),
                HasSubstr("object 'thing' is 0.100 x 0.020 x 0.000 m and does not fit"));
  }
}

TEST(DegenerateLayout, TurnsOfFlatObjectsAreRotations) {
  const ObjectSet objects = FlatObjects();
  Rng rng(1);
  for (int i = 0; i < static_cast<int>(objects.size()); ++i) {
    for (const int attempts : {0, 20}) {
      for (const Bin& bin : {kWideBin, kNoFloor}) {
        const RotatedObject turned = TurnAtRandom(objects, ObjectId(i), bin, 0, attempts, rng);
        EXPECT_LT((turned.R_WO * turned.R_WO.transpose() - Matrix3d::Identity()).norm(), 1e-9);
        EXPECT_NEAR(turned.R_WO.determinant(), 1, 1e-9);
        EXPECT_TRUE(turned.box.isApprox(RotatedBox(*objects[i], turned.R_WO)));
      }
    }
  }
  // Without an attempt, the longest axis is parallel to the longer side of the floor.
  const Vector3d size = TurnAtRandom(objects, ObjectId(3), kWideBin, 0, 0, rng).box.sizes();
  EXPECT_LT((size - Vector3d(0.1, 0.02, 0)).norm(), 1e-12);
}

TEST(DegenerateLayout, LayersOfFewOrSmallInstancesHaveCellsInTheBin) {
  EXPECT_TRUE(PackLayer({}, 0, kWideBin, 0.003).empty());
  const auto box_of = [](const ObjectModel& model) {
    return RotatedObject{ObjectId(0), Matrix3d::Identity(),
                         RotatedBox(model, Matrix3d::Identity())};
  };
  const std::vector<RotatedObject> points(1000, box_of(*ObjectOfPoints({kPoint})));
  EXPECT_TRUE(PackLayer(points, points.size(), kWideBin, 0.003).empty());
  const std::vector<Cell> cells = PackLayer(points, 0, kWideBin, 0.003);
  EXPECT_EQ(cells.size(), points.size());
  for (size_t i = 1; i < cells.size(); ++i) {
    EXPECT_NE(cells[i].low, cells[i - 1].low);
    EXPECT_TRUE((cells[i].low.array() > 0).all());
    EXPECT_LT(cells[i].low.x(), 0.4);
    EXPECT_LT(cells[i].low.y(), 0.2);
  }
  // The first instance gets a cell, whatever its size.
  const std::vector<RotatedObject> large(3, box_of(*BoxObject({1, 1, 1}, 1)));
  EXPECT_EQ(PackLayer(large, 0, kWideBin, 0.003).size(), 1u);
  EXPECT_EQ(PackLayer(large, 2, kNoFloor, 0.003).size(), 1u);
}

TEST(DegenerateLayout, UprightInstancesAreInTheBinOrLeftOut) {
  ObjectSet objects = FlatObjects();
  objects.push_back(BoxObject({1, 1, 1}, 1));
  std::vector<ObjectId> kinds;
  for (int i = 0; i < static_cast<int>(objects.size()); ++i) kinds.emplace_back(i);
  Rng rng(1);
  EXPECT_TRUE(PlaceUpright(objects, {}, kWideBin, 0.003, 100, rng).empty());
  EXPECT_TRUE(PlaceUpright(objects, kinds, kWideBin, 0.003, 0, rng).empty());
  const auto placed = PlaceUpright(objects, kinds, kWideBin, 0.003, 100, rng);
  EXPECT_EQ(placed.size(), 4u);  // all but the cube of 1 m
  for (const PlacedInstance& instance : placed) {
    Eigen::AlignedBox3d box = RotatedBox(*objects[instance.object], instance.X_WO.linear());
    box.translate(instance.X_WO.translation());
    EXPECT_NEAR(box.min().z(), 0.003, 1e-12);
    EXPECT_LE(box.max().x(), 0.2);
    EXPECT_GE(box.min().x(), -0.2);
    EXPECT_LE(box.max().y(), 0.1);
    EXPECT_GE(box.min().y(), -0.1);
  }
  // Two points cannot be apart on a floor that is a point.
  const std::vector<ObjectId> twice{ObjectId(0), ObjectId(0)};
  EXPECT_EQ(PlaceUpright(objects, twice, kNoFloor, 0, 100, rng).size(), 1u);
}

TEST(DegeneratePenetration, FlatPiecesOverlapNothing) {
  ObjectSet objects = FlatObjects();
  objects.push_back(ObjectOfPoints({}));
  objects.push_back(BoxObject(Vector3d::Constant(0.04), 0.1));
  Scene scene;
  EXPECT_EQ(DeepestPenetration(scene, {}), 0);
  EXPECT_TRUE(OverlapsDeeperThan(0, scene, {}).empty());
  for (int i = 0; i < static_cast<int>(objects.size()); ++i) {
    scene.objects.push_back({InstanceId(i), ObjectId(i), Translation({0, 0, 0.5})});
  }
  EXPECT_EQ(DeepestPenetration(scene, objects), 0);
  EXPECT_TRUE(OverlapsDeeperThan(0, scene, objects).empty());
}

TEST(DegeneratePenetration, InstancesAtOnePlaceOverlapByTheirWidth) {
  const ObjectSet objects{BoxObject({0.04, 0.06, 0.08}, 0.1)};
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    scene.objects.push_back({InstanceId(i), ObjectId(0), Translation({0, 0, 0.5})});
  }
  EXPECT_NEAR(DeepestPenetration(scene, objects), 0.04, 1e-12);
  EXPECT_EQ(OverlapsDeeperThan(0.039, scene, objects).size(), 3u);
  EXPECT_TRUE(OverlapsDeeperThan(0.041, scene, objects).empty());
}

TEST(DegenerateMovement, PointsMoveByTheirDistance) {
  const Eigen::AlignedBox3d point(Vector3d(1, 0, 0), Vector3d(1, 0, 0));
  const Pose half_turn(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ()));
  Movement movement;
  movement.Include(point, 0.5, Pose::Identity(), Pose::Identity());
  EXPECT_EQ(movement.m, 0);
  movement.Include(point, 0, half_turn, half_turn);  // an object without a diameter
  EXPECT_NEAR(movement.m, 0, 1e-6);
  EXPECT_FALSE(std::isnan(movement.diameters));
  Movement turned;
  turned.Include(point, 0.5, Pose::Identity(), half_turn);
  EXPECT_NEAR(turned.m, 2, 1e-9);
  EXPECT_NEAR(turned.diameters, 4, 1e-9);
}

TEST(DegenerateFill, OnlySurfacesThatAreSeenFromAboveFill) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    auto object = std::make_shared<ObjectModel>();
    object->mesh_O = test.mesh;
    const PosedObject posed{InstanceId(0), ObjectId(0), Translation({0, 0, 0.05})};
    const FillStatistics fill = MeasureFill({kWideBin, {posed, posed}}, {object});
    const bool is_seen = test.has_area && test.name != "a sliver" && test.name != "a far box" &&
                         test.name != "a tiny box";
    EXPECT_EQ(fill.fill_level > 0, is_seen) << test.name;
    EXPECT_TRUE(std::isfinite(fill.fill_level)) << test.name;
    // Equal instances do not cover each other.
    EXPECT_EQ(fill.layers, (std::vector<int>{1, 1})) << test.name;
    EXPECT_EQ(fill.above, (std::vector<int>{0, 0})) << test.name;
    EXPECT_EQ(fill.below, (std::vector<int>{0, 0})) << test.name;
    if (test.name == "one triangle") {
      // Half of a square of 100 mm at half of the bin's height, over 0.08 m^2.
      EXPECT_NEAR(fill.fill_level, 0.5 * 0.005 / 0.08, 1e-3);
    }
  }
}

TEST(DegenerateDistractors, NeedADiameter) {
  EXPECT_TRUE(MakeDistractors({}).empty());
  EXPECT_THAT(ErrorOf([] { MakeDistractors({ObjectOfPoints({kPoint})}); }),
              HasSubstr("not positive"));
  // Hulls of four points often are nearly flat.
  const ObjectSet shapes =
      MakeDistractors({ObjectOfPoints(kPlate)},
                      {.per_object = 50, .corners_min = 4, .corners_max = 4, .flattest = 0.01});
  ASSERT_EQ(shapes.size(), 50u);
  for (const auto& shape : shapes) {
    EXPECT_GT(shape->mass.volume_m3, 0);
    EXPECT_NEAR(Diameter(shape->mesh_O), shape->diameter_m, 1e-9);
  }
}

TEST(DegenerateRest, NeedsPieces) {
  EXPECT_THROW(FindRestingPoses(*ObjectOfPoints({}), 1), std::logic_error);
}

}  // namespace
}  // namespace pickbed::tests
