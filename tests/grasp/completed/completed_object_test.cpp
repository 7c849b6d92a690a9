#include "grasp/completed/completed_object.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/grasp/completed/shape_source.h"
#include "tests/support/layer.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;

constexpr double kBall_m = 0.02;
const Vector3d kCenter_W(0.1, -0.05, 0.03);
const double kVolume_m3 = 4.0 / 3 * std::numbers::pi * std::pow(kBall_m, 3);

TEST(CompletedObject, ASphereHasItsMassAndCenter) {
  const OccupancyShape shape = SphereShape(kBall_m, Translation(kCenter_W), 64);
  const Pose X_WB = Translation({0.3, 0.2, 0.1}) * Pose(Eigen::AngleAxisd(0.5, Vector3d::UnitZ()));
  const auto object =
      MakeCompletedObject(shape, X_WB.inverse(), {.density_kgpm3 = 2000, .friction = 0.3});
  ASSERT_TRUE(object);
  EXPECT_NEAR(object->model->mass.mass_kg, 2000 * kVolume_m3, 0.05 * 2000 * kVolume_m3);
  const Vector3d center_W = X_WB * object->X_BO * object->model->mass.com_O;
  EXPECT_LT((center_W - kCenter_W).norm(), 0.1 * shape.cell_m);
  EXPECT_EQ(object->model->friction, 0.3);
  EXPECT_TRUE(object->model->convex_pieces_O.empty());
}

// The probability falls with the distance from the center, so that a lower level gives a larger
// object.
TEST(CompletedObject, ItsSurfaceIsAtTheLevel) {
  const OccupancyShape shape = ShapeOfBody(0.1, 64, Pose::Identity(), [](const Vector3d& p) {
    return std::max(0.0, 1 - p.norm() / 0.04);
  });
  for (const double level : {0.3, 0.6}) {
    const auto object = MakeCompletedObject(shape, Pose::Identity(), {.surface_level = level});
    ASSERT_TRUE(object);
    const double radius_m = 0.5 * MeshBounds(object->model->mesh_O).size().x();
    EXPECT_NEAR(radius_m, 0.04 * (1 - level), 0.5 * shape.cell_m);
  }
}

TEST(CompletedObject, SmallPiecesAreLeftOut) {
  const OccupancyShape shape = ShapeOfBody(0.1, 64, Pose::Identity(), [](const Vector3d& p) {
    const bool is_speck = (p - Vector3d(0.035, 0, 0)).norm() < 0.006;
    return p.norm() < kBall_m || is_speck ? 1.0 : 0.0;
  });
  const auto object = MakeCompletedObject(shape, Pose::Identity(), {});
  ASSERT_TRUE(object);
  EXPECT_LT(MeshBounds(object->model->mesh_O).size().x(), 2.2 * kBall_m);
}

TEST(CompletedObject, AnEmptyShapeHasNoObject) {
  OccupancyShape shape = SphereShape(kBall_m, Pose::Identity());
  for (float& probability : shape.occupancy) probability = 0.1f;
  EXPECT_FALSE(MakeCompletedObject(shape, Pose::Identity(), {}));
}

}  // namespace
}  // namespace pickbed::tests
