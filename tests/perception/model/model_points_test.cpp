#include "perception/model/model_points.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "scenes/base/error.h"
#include "scenes/geometry/mesh_query.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

Eigen::Vector3d D(const Eigen::Vector3f& v) { return v.cast<double>(); }

TEST(MakeModelPoints, PointsAreOnTheSurfaceWithItsNormals) {
  const auto object = ObjectOf(BracketMesh());
  const MeshQuery query(object->mesh_O);
  const ModelPoints model = MakeModelPoints(*object, 800, 20);
  ASSERT_EQ(model.points_O.size(), 800u);
  for (size_t i = 0; i < model.points_O.size(); ++i) {
    EXPECT_LT(query.ClosestPoint(D(model.points_O[i])).distance, 1e-6);
    EXPECT_NEAR(model.normals_O[i].norm(), 1, 1e-5);
  }
  EXPECT_NEAR(model.area_per_point_m2 * 800, SurfaceArea(object->mesh_O), 1e-6);
  EXPECT_NEAR(model.diameter_m, object->diameter_m, 1e-6);
}

// If N points are evenly distributed, no nearest neighbour is much closer than the spacing
// sqrt(area / N). For random points, the mean of that distance is half the spacing and its minimum
// is nearly zero.
TEST(MakeModelPoints, EveryPrefixIsEvenlyDistributed) {
  const auto object = ObjectOf(BoxMesh({0.08, 0.08, 0.04}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*object, 1000, 2);
  for (const int n : {50, 200, 1000}) {
    const double spacing = std::sqrt(SurfaceArea(object->mesh_O) / n);
    double nearest = 1;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) {
        // Across an edge, points may be closer.
        if (model.normals_O[i].dot(model.normals_O[j]) < 0.9) continue;
        nearest = std::min<double>(nearest, (model.points_O[i] - model.points_O[j]).norm());
      }
    }
    EXPECT_GT(nearest, 0.5 * spacing) << n;
  }
}

TEST(MakeModelPoints, ExactlyTheFacingFacesOfABoxAreVisible) {
  const auto object = ObjectOf(BoxMesh({0.06, 0.04, 0.02}, {0.01, 0, 0}));
  const ModelPoints model = MakeModelPoints(*object, 600, 100);
  for (size_t d = 0; d < model.directions_O.size(); ++d) {
    std::vector<bool> visible(600);
    for (const int i : model.visible[d]) visible[i] = true;
    for (int i = 0; i < 600; ++i) {
      const float facing = model.normals_O[i].dot(model.directions_O[d]);
      if (std::abs(facing) > 0.2) {
        EXPECT_EQ(visible[i], facing > 0) << d << " " << i;
      }
    }
  }
}

// Compares with rays that are cast from the points along the direction.
TEST(MakeModelPoints, SelfOcclusionAgreesWithRays) {
  const auto object = ObjectOf(BracketMesh());
  const MeshQuery query(object->mesh_O);
  const ModelPoints model = MakeModelPoints(*object, 1000, 60);
  int facing = 0, occluded = 0, wrong = 0;
  for (size_t d = 0; d < model.directions_O.size(); ++d) {
    for (int i = 0; i < 1000; ++i) {
      if (model.normals_O[i].dot(model.directions_O[d]) < 0.2) continue;
      const bool blocked =
          query.Raycast(D(model.points_O[i]), D(model.directions_O[d]), 1e-5, 1).has_value();
      const bool visible = std::binary_search(model.visible[d].begin(), model.visible[d].end(), i);
      ++facing;
      occluded += blocked;
      wrong += visible == blocked;
    }
  }
  EXPECT_GT(occluded, facing / 20);
  EXPECT_LT(wrong, occluded / 5);  // within a raster pixel and its slope of the edge of a shadow
  EXPECT_LT(wrong, facing / 40);
}

TEST(ModelPoints, VisibleFromUsesTheCameraDirection) {
  const auto object = ObjectOf(BoxMesh({0.06, 0.04, 0.02}, Eigen::Vector3d::Zero()));
  const ModelPoints model = MakeModelPoints(*object, 600, 200);
  // The object's +x faces the camera: x_O = -z_C.
  Pose X_CO = Pose::Identity();
  X_CO.linear() << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  X_CO.translation() << 0.1, -0.05, 0.8;
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  ASSERT_FALSE(visible.empty());
  const auto front = std::count_if(visible.begin(), visible.end(),
                                   [&](int i) { return model.normals_O[i].x() > 0.9; });
  const auto back = std::count_if(visible.begin(), visible.end(),
                                  [&](int i) { return model.normals_O[i].x() < -0.1; });
  EXPECT_GT(front, 10);
  EXPECT_EQ(back, 0);
}

TEST(DistanceField, AgreesWithTheMesh) {
  const auto object = ObjectOf(BracketMesh());
  const MeshQuery query(object->mesh_O);
  const ModelPoints model = MakeModelPoints(*object, 500, 2);
  Rng rng(11);
  double sum = 0;
  constexpr int kPoints = 3000;
  for (int i = 0; i < kPoints; ++i) {
    const Eigen::Vector3d p(rng.Uniform(-0.04, 0.04), rng.Uniform(-0.025, 0.025),
                            rng.Uniform(-0.034, 0.034));
    const double exact = query.ClosestPoint(p).distance;
    const double off = model.distance.At(p.cast<float>()) - exact;
    // At folds (the surface, the center of a wall) interpolation is off by half a cell.
    EXPECT_LT(std::abs(off), 0.6 * model.distance.cell_m);
    sum += std::abs(off);
  }
  EXPECT_LT(sum / kPoints, 0.0002);
  EXPECT_EQ(model.distance.At({1, 0, 0}), DistanceField::kOutside_m);
  EXPECT_EQ(model.distance.At({NAN, 0, 0}), DistanceField::kOutside_m);
}

TEST(MakeModelPoints, SameObjectSamePoints) {
  const auto object = ObjectOf(BracketMesh());
  const ModelPoints a = MakeModelPoints(*object, 300, 10), b = MakeModelPoints(*object, 300, 10);
  EXPECT_EQ(a.points_O, b.points_O);
  EXPECT_EQ(a.visible, b.visible);
  EXPECT_EQ(a.distance.distance_m, b.distance.distance_m);
}

TEST(MakeModelPoints, BadInputIsReported) {
  EXPECT_THAT([] { MakeModelPoints(*ObjectOf(BracketMesh()), 70000, 10); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("70000 model points")));
  ObjectModel flat;
  flat.name = "nothing";
  EXPECT_THAT([&] { MakeModelPoints(flat); },
              ::testing::ThrowsMessage<InputError>(::testing::HasSubstr("'nothing' has no area")));
}

}  // namespace
}  // namespace pickbed::tests
