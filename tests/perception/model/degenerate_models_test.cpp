// Points, distances, colors and ambiguous poses of objects without extent or area, and of poses at
// the camera.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "perception/model/ambiguous_poses.h"
#include "perception/model/edge_points.h"
#include "perception/model/model_points.h"
#include "perception/model/pose_distance.h"
#include "perception/model/surface_texture.h"
#include "scenes/base/error.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/cloud_options.h"
#include "tests/support/degenerate_depth.h"
#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using testing::HasSubstr;

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

TEST(DegenerateDistanceField, SamplesWithoutExtentAndBadSamplesAreRefused) {
  const Vector3f p(0.1f, 0.2f, 0.3f);
  const std::vector<Vector3f> one{p}, same(5, p);
  for (const std::vector<Vector3f>& samples : {one, same}) {
    EXPECT_THAT(ErrorOf([&] { MakeDistanceField(samples, 0, 16); }), HasSubstr("padding"));
    EXPECT_THAT(ErrorOf([&] { MakeDistanceField(samples, kNotANumber, 16); }),
                HasSubstr("padding"));
    EXPECT_THAT(ErrorOf([&] { MakeDistanceField(samples, 0.01, 3); }), HasSubstr("4 nodes"));
  }
  for (const double bad : {kNotANumber, std::numeric_limits<double>::infinity()}) {
    for (const size_t at : {0, 1, 2}) {
      std::vector<Vector3f> samples{p, 2 * p, 3 * p};
      samples[at].y() = static_cast<float>(bad);
      EXPECT_THAT(ErrorOf([&] { MakeDistanceField(samples, 0.01, 16); }), HasSubstr("not finite"));
    }
  }
}

TEST(DegenerateDistanceField, SurfacesWithoutVolumeHaveNoDepth) {
  const Vector3f p(0.1f, 0.2f, 0.3f), x = Vector3f::UnitX(), y = Vector3f::UnitY();
  std::vector<Vector3f> plane;
  for (int i = 0; i < 400; ++i) {
    plane.push_back(p + 0.002f * static_cast<float>(i % 20) * x +
                    0.002f * static_cast<float>(i / 20) * y);
  }
  const std::vector<Vector3f> one{p}, line{p, p + 0.01f * x, p + 0.02f * x};
  for (const std::vector<Vector3f>& samples : {one, line, plane}) {
    const DistanceField field = MakeDistanceField(samples, 0.01, 16);
    EXPECT_EQ(std::count(field.is_inside.begin(), field.is_inside.end(), 1), 0);
    EXPECT_EQ(field.DepthAt(p), 0);
    EXPECT_EQ(field.DepthAt(p + 0.003f * x), 0);
    EXPECT_EQ(field.DepthAt(Vector3f::Constant(static_cast<float>(kNotANumber))), 0);
  }
  const DistanceField none;
  EXPECT_EQ(none.At(p), DistanceField::kOutside_m);
  EXPECT_EQ(none.At(Vector3f::Zero()), DistanceField::kOutside_m);
  EXPECT_EQ(none.DepthAt(Vector3f::Zero()), 0);
}

TEST(DegenerateDistanceField, AFlatGridHoldsItsPlane) {
  const std::vector<Vector3f> square{{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}, {0.1f, 0.1f, 0}};
  const DistanceField field = MakeDistanceField(square, 0, 11);
  EXPECT_EQ(field.size, Eigen::Vector3i(11, 11, 1));
  for (const float distance_m : field.distance_m) EXPECT_LE(distance_m, 0.0708f);
  EXPECT_EQ(field.At({0.05f, 0.05f, 0}), DistanceField::kOutside_m);  // there is no second layer
}

TEST(DegenerateEdgePoints, AreNoneWithoutEdges) {
  EXPECT_TRUE(MakeEdgePoints({}).empty());
  EXPECT_TRUE(MakeEdgePoints(BoxShape({0.1, 0.2, 0.3}), 0).empty());
  EXPECT_EQ(MakeEdgePoints(BoxShape({0.1, 0.2, 0.3}), 1).size(), 1u);
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    // Two equal faces have equal normals at their edges, so these are not sharp.
    const bool has_edges = test.has_area && test.name != "a face twice";
    EXPECT_EQ(!MakeEdgePoints(test.mesh).empty(), has_edges) << test.name;
    EXPECT_LE(MakeEdgePoints(test.mesh, 100).size(), 100u) << test.name;
  }
}

TEST(DegeneratePoseDistances, NeedAnExtent) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    const auto object = ObjectOf(test.mesh);
    if (object->diameter_m > 0) {
      EXPECT_EQ(PoseDistance(*object).diameter_m(), object->diameter_m) << test.name;
      EXPECT_EQ(PoseEmbedding(*object).Distance(BracketPose(), BracketPose()), 0) << test.name;
      const Pose shifted = BracketPose() * Translation({object->diameter_m, 0, 0});
      EXPECT_NEAR(PoseDistance(*object)(BracketPose(), shifted), 1, 1e-6) << test.name;
      continue;
    }
    EXPECT_THAT(ErrorOf([&] { PoseDistance distance(*object); }), HasSubstr("has no extent"))
        << test.name;
    EXPECT_THAT(ErrorOf([&] { PoseEmbedding embedding(*object); }), HasSubstr("has no extent"))
        << test.name;
  }
}

// The leverage of the center is 1, also where the key points are in a plane or on a line.
TEST(DegeneratePoseDistances, CenterHasLeverageOne) {
  const Vector3d a(0, 0, 0), b(0.1, 0, 0), c(0, 0.1, 0);
  for (const TriangleMesh& mesh :
       {MeshOf({a, b}, {{0, 1, 1}}), MeshOf({a, b, c}, {{0, 1, 2}}), BoxShape({0.1, 0.2, 0.3})}) {
    const PoseEmbedding embedding(*ObjectOf(mesh));
    EXPECT_NEAR(embedding.Leverage(MeshBounds(mesh).center()), 1, 1e-6);
    EXPECT_GT(embedding.Leverage(mesh.vertices[1]), 1);
  }
}

TEST(DegenerateRotationDistance, IsAnAngleForAllSymmetries) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ(), zero = Vector3d::Zero();
  const ContinuousSymmetry about_z{z, zero}, about_x{x, zero};
  const SymmetrySet none, axis{{}, {about_z}}, axis_twice{{}, {about_z, about_z}},
      ball{{}, {about_z, about_x}}, same{{Pose::Identity(), Pose::Identity()}, {}};
  const Eigen::Matrix3d about = Eigen::AngleAxisd(1, z).toRotationMatrix();
  const Eigen::Matrix3d flip = Eigen::AngleAxisd(std::numbers::pi, x).toRotationMatrix();
  for (const SymmetrySet& set : {none, axis, axis_twice, ball, same}) {
    const RotationDistance distance(set);
    EXPECT_NEAR(distance(I, I), 0, 1e-7);
    EXPECT_NEAR(distance(flip, flip), 0, 1e-7);
    EXPECT_NEAR(distance(I, flip), SecondAxis(set) ? 0 : std::numbers::pi, 1e-6);
    EXPECT_NEAR(distance(I, about), set.continuous_O.empty() ? 1 : 0, 1e-6);
  }
}

TEST(DegenerateAmbiguousPoses, AreFiniteAndApart) {
  const AmbiguousPoseOptions options;
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (!test.has_area) continue;
    const auto object = ObjectOf(test.mesh);
    const PoseDistance distance(*object);
    const auto poses = AmbiguousPoses(*object, MakeModelPoints(*object, 50, 20), distance, options);
    EXPECT_LE(poses.size(), static_cast<size_t>(options.max_poses)) << test.name;
    for (const Pose& S_O : poses) {
      EXPECT_TRUE(S_O.matrix().allFinite()) << test.name;
      EXPECT_GE(distance(S_O, Pose::Identity()), options.min_move_diameters) << test.name;
    }
  }
}

TEST(DegenerateAmbiguousPoses, NoneAreReturnedIfNoneAreAskedFor) {
  const auto object = ObjectOf(BoxMesh({0.06, 0.04, 0.03}, Vector3d::Zero()));
  const ModelPoints points = MakeModelPoints(*object, 50, 20);
  AmbiguousPoseOptions options;
  ASSERT_FALSE(AmbiguousPoses(*object, points, PoseDistance(*object), options).empty());
  options.max_poses = 0;
  EXPECT_TRUE(AmbiguousPoses(*object, points, PoseDistance(*object), options).empty());
}

TEST(DegenerateViewsOfModels, VisiblePointsExistForEveryPose) {
  const ModelPoints model = MakeModelPoints(*ObjectOf(BracketMesh()), 200, 1);
  const ModelPoints one = MakeModelPoints(*ObjectOf(BracketMesh()), 1, 20);
  EXPECT_EQ(one.points_O.size(), 1u);
  const Pose at_center = Translation(-model.center_O.cast<double>());
  for (const Pose& X_CO : {Pose::Identity(), at_center, Translation({0, 0, 1e300}),
                           Translation(Vector3d::Constant(kNotANumber))}) {
    EXPECT_EQ(&model.VisibleFrom(X_CO), &model.visible[0]);
    for (const uint16_t i : one.VisibleFrom(X_CO)) EXPECT_EQ(i, 0);
  }
}

TEST(DegenerateSeenPoints, AreReadingsOfTheImage) {
  const ModelPoints model = MakeModelPoints(*ObjectOf(BracketMesh()), 400, 60);
  float nearest_m = std::numeric_limits<float>::max();
  for (const Eigen::Vector3f& p_O : model.points_O) nearest_m = std::min(nearest_m, p_O.z());
  const Pose touches_plane = Translation({0, 0, 0.8 - nearest_m});
  size_t seen = 0;
  for (const DepthCase& test : DepthCases()) {
    const OrganizedCloud cloud = BuildCloud(FrameOf(test), std::nullopt, kKeepAll);
    for (const Pose& X_CO :
         {BracketPose(), touches_plane, Translation({0, 0, 0.8}), Pose::Identity(),
          Translation({0, 0, -0.8}), Translation({0, 0, 1e30})}) {
      for (const auto& [point, pixel] : SeenPoints(cloud, model, X_CO)) {
        ASSERT_LT(static_cast<size_t>(point), model.points_O.size()) << test.name;
        ASSERT_LT(static_cast<size_t>(pixel), cloud.points_C.size()) << test.name;
        EXPECT_GT(cloud.depth_m.data()[pixel], 0) << test.name;
        ++seen;
      }
    }
    if (test.depth_m(160, 120) > 0) continue;
    EXPECT_TRUE(SeenPoints(cloud, model, Translation({0, 0, 0.8})).empty()) << test.name;
  }
  EXPECT_GT(seen, 0u) << "no case checked a point";
}

TriangleMesh WithColors(TriangleMesh mesh) {
  mesh.colors.assign(mesh.vertices.size(), {10, 20, 30});
  return mesh;
}

TEST(DegenerateTexture, FacesWithoutAreaHaveTheColorOfACorner) {
  const std::vector<int> faces{0, 0};
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    if (test.mesh.triangles.empty()) continue;
    const auto object = ObjectOf(WithColors(test.mesh));
    const std::vector<Vector3d> points{test.mesh.vertices[0], test.mesh.vertices[0]};
    const SurfaceTexture texture = MakeSurfaceTexture(*object, points, faces);
    ASSERT_EQ(texture.colors.size(), 2u) << test.name;
    for (const Vector3f& color : texture.colors) {
      EXPECT_LT((color - Vector3f(10, 20, 30)).norm(), 0.01f) << test.name;
    }
    EXPECT_TRUE(MakeSurfaceTexture(*object, {}, {}).colors.empty()) << test.name;
    EXPECT_TRUE(MakeSurfaceTexture(*ObjectOf(test.mesh), points, faces).colors.empty());
  }
}

// All corners have one place in the texture, so a texel has no size on the surface.
TEST(DegenerateTexture, OneTexelColorsTheSurface) {
  TriangleMesh mesh = BoxShape({0.1, 0.2, 0.3});
  mesh.texture = Image<Rgb8>(1, 1, {200, 100, 50});
  for (const Eigen::Vector2d& uv : {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 1),
                                    Eigen::Vector2d(-1e6, 1e6), Eigen::Vector2d(0.5, 0.5)}) {
    mesh.uvs.assign(mesh.vertices.size(), uv);
    const std::vector<Vector3d> points{mesh.vertices[0]};
    const SurfaceTexture texture = MakeSurfaceTexture(*ObjectOf(mesh), points, std::vector<int>{0});
    ASSERT_EQ(texture.colors.size(), 1u);
    EXPECT_EQ(texture.colors[0], Vector3f(200, 100, 50));
  }
}

TEST(DegenerateTexture, IsNotFoundWithoutReadingsOrContrast) {
  TriangleMesh mesh = BoxShape({0.1, 0.1, 0.1});
  for (int i = 0; i < 8; ++i) {
    mesh.colors.push_back(i % 2 ? Rgb8{250, 250, 250} : Rgb8{10, 10, 10});
  }
  const ModelPoints model = MakeModelPoints(*ObjectOf(mesh), 500, 60);
  const Pose X_CO = Translation({0, 0, 0.4});
  SyntheticDepth scene(SmallCamera());
  scene.AddMesh(mesh, X_CO);
  RgbdFrame frame = scene.frame();
  EXPECT_FALSE(TextureCorrelation(BuildCloud(frame, std::nullopt, kKeepAll), model, X_CO));
  frame.color = Image<Rgb8>(frame.depth_m.width(), frame.depth_m.height(), {90, 90, 90});
  const auto grey = TextureCorrelation(BuildCloud(frame, std::nullopt, kKeepAll), model, X_CO);
  ASSERT_TRUE(grey);
  EXPECT_LT(*grey, kTextureFound);
  EXPECT_GE(*grey, 0);
  const ModelPoints one_color = MakeModelPoints(*ObjectOf(WithColors(mesh)), 500, 60);
  EXPECT_FALSE(TextureCorrelation(BuildCloud(frame, std::nullopt, kKeepAll), one_color, X_CO));
  frame.depth_m = Image<float>(frame.depth_m.width(), frame.depth_m.height());
  EXPECT_FALSE(TextureCorrelation(BuildCloud(frame, std::nullopt, kKeepAll), model, X_CO));
}

}  // namespace
}  // namespace pickbed::tests
