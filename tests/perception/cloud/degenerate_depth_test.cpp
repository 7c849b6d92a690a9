// Degenerate depth images through all stages that measure geometry: points, normals, planes, fits
// and the three kinds of ICP. No stage passes on a value that is not finite.

#include "tests/support/degenerate_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "perception/cloud/background_fit.h"
#include "perception/cloud/organized_cloud.h"
#include "perception/features/neighbors.h"
#include "perception/icp/final_refinement.h"
#include "perception/model/distance_field.h"
#include "perception/model/edge_points.h"
#include "perception/model/model_points.h"
#include "perception/model/pose_distance.h"
#include "perception/verify/pose_features.h"
#include "perception/voting/pose_clustering.h"
#include "scenes/base/error.h"
#include "scenes/base/finite_counts.h"
#include "tests/scenes/geometry/degenerate_meshes.h"
#include "tests/support/synthetic_depth.h"

namespace pickbed::tests {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinite = std::numeric_limits<float>::infinity();

void ExpectFinite(const OrganizedCloud& cloud, const std::string& name) {
  EXPECT_TRUE(std::isfinite(cloud.depth_statistics.Error_m())) << name;
  for (size_t i = 0; i < cloud.points_C.size(); ++i) {
    ASSERT_TRUE(cloud.points_C[i].allFinite()) << name << " " << i;
    ASSERT_TRUE(std::isfinite(cloud.depth_m.data()[i]) && cloud.depth_m.data()[i] >= 0) << name;
    const float norm = cloud.normals_C[i].norm();
    ASSERT_TRUE(norm == 0 || std::abs(norm - 1) < 1e-3f) << name << " " << norm;
  }
  for (const int pixel : cloud.foreground_pixels) {
    ASSERT_GT(cloud.points_C[pixel].z(), 0) << name;
  }
  for (const BackgroundPlane& plane : cloud.planes) {
    EXPECT_NEAR(plane.normal_C.norm(), 1, 1e-3) << name;
    EXPECT_TRUE(std::isfinite(plane.offset_m)) << name;
  }
}

TEST(DegenerateDepth, CloudsAreFiniteAndBadReadingsAreCounted) {
  for (const DepthCase& test : DepthCases()) {
    for (const double min_plane_share : {0.25, 1.0}) {
      TakeNotFiniteCounts();
      const OrganizedCloud cloud =
          BuildCloud(FrameOf(test), std::nullopt, {.min_plane_share = min_plane_share});
      ExpectFinite(cloud, test.name);
      const StageSeconds counts = TakeNotFiniteCounts();
      const auto depth = counts.find("not_finite/depth");
      EXPECT_EQ(depth == counts.end() ? 0 : depth->second, test.not_finite) << test.name;
    }
    const Bin bin;
    ExpectFinite(BuildCloud(FrameOf(test), KnownBackground{bin, Translation({0, 0, 0.9})}),
                 test.name);
  }
}

TEST(DegenerateDepth, EveryRefinerGivesAFinitePose) {
  const auto object = ObjectOf(BracketMesh());
  const std::vector<ModelPoints> models = {MakeModelPoints(*object, 400, 60)};
  for (const DepthCase& test : DepthCases()) {
    const OrganizedCloud cloud = BuildCloud(FrameOf(test), std::nullopt, {.min_plane_share = 1});
    for (const RefinerRow& row : RefinerTable()) {
      std::vector<PoseHypothesis> hypotheses(4);
      hypotheses[0].X_CO = BracketPose();
      hypotheses[1].X_CO = Translation({0, 0, 0.8});
      hypotheses[2].X_CO = Translation({0, 0, -0.8});
      hypotheses[3].X_CO = Translation({0, 0, 0});
      RefineFinally(*row.make(), cloud, models, 1, hypotheses);
      for (const PoseHypothesis& h : hypotheses) {
        EXPECT_TRUE(h.X_CO.matrix().allFinite()) << test.name << " " << row.name;
        EXPECT_TRUE(std::isfinite(h.fit.residual_m)) << test.name << " " << row.name;
        EXPECT_TRUE(std::isfinite(h.fit.inlier_share)) << test.name << " " << row.name;
        EXPECT_TRUE(std::isfinite(h.fit.reciprocal_condition_number)) << test.name;
      }
    }
  }
}

TEST(DegenerateDepth, VerifierInputsAreFinite) {
  const auto object = ObjectOf(BracketMesh());
  const ModelPoints model = MakeModelPoints(*object, 400, 60);
  const DepthEvidenceOf evidence_of(*object);
  EvidenceScratch scratch;
  for (const DepthCase& test : DepthCases()) {
    const OrganizedCloud cloud = BuildCloud(FrameOf(test), std::nullopt, {.min_plane_share = 1});
    for (const Pose& X_CO : {BracketPose(), Translation({0, 0, 0.8}), Translation({0, 0, -0.8}),
                             Translation({0, 0, 1e6}), Translation({0, 0, 0})}) {
      const DepthEvidence evidence = evidence_of(cloud, X_CO, scratch, 1000);
      FitReport fit;
      const VerifyFeatures features =
          ComputeVerifyFeatures(cloud, model, X_CO, evidence, {}, 0, fit);
      for (const float value : features) EXPECT_TRUE(std::isfinite(value)) << test.name;
      EXPECT_TRUE(std::isfinite(fit.residual_m) && std::isfinite(fit.inlier_share)) << test.name;
    }
  }
}

TEST(DegeneratePoints, PlanesOfFewOrEqualPointsAreFiniteOrNone) {
  const Eigen::Vector3f p(0.1f, 0.2f, 0.8f);
  std::vector<std::vector<Eigen::Vector3f>> clouds = {
      {}, {p}, {p, p}, std::vector<Eigen::Vector3f>(500, p)};
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 500; ++i) line.push_back(p + 0.001f * static_cast<float>(i) * p);
  clouds.push_back(line);
  for (const auto& points : clouds) {
    for (const BackgroundPlane& plane : FitBackground(points, {})) {
      EXPECT_NEAR(plane.normal_C.norm(), 1, 1e-3) << points.size();
      EXPECT_TRUE(std::isfinite(plane.offset_m)) << points.size();
    }
  }
}

TEST(DegeneratePoints, DistanceFieldsAreFiniteOrRefused) {
  const Eigen::Vector3f p(0.1f, 0.2f, 0.3f);
  EXPECT_THROW(MakeDistanceField({}, 0.01, 16), InputError);
  std::vector<std::vector<Eigen::Vector3f>> samples = {{p}, {p, p, p}, {p, 2 * p, 3 * p}};
  for (const auto& some : samples) {
    const DistanceField field = MakeDistanceField(some, 0.01, 16);
    for (const float distance : field.distance_m) ASSERT_TRUE(std::isfinite(distance));
    EXPECT_LT(field.At(p), 0.1f);
    EXPECT_EQ(field.At({kNaN, 0, 0}), DistanceField::kOutside_m);
    EXPECT_EQ(field.At({kInfinite, 0, 0}), DistanceField::kOutside_m);
  }
}

TEST(DegenerateModels, PointsNeedAnArea) {
  for (const DegenerateMesh& test : DegenerateMeshes()) {
    ObjectModel object;
    object.mesh_O = test.mesh;
    object.diameter_m = Diameter(test.mesh);
    object.mesh_hash = MeshHash(test.mesh);
    try {
      const ModelPoints model = MakeModelPoints(object, 50, 20);
      EXPECT_TRUE(test.has_area) << test.name;
      for (size_t i = 0; i < model.points_O.size(); ++i) {
        EXPECT_TRUE(model.points_O[i].allFinite()) << test.name;
        EXPECT_NEAR(model.normals_O[i].norm(), 1, 1e-3) << test.name;
      }
      EXPECT_TRUE(std::isfinite(model.radius_m) && model.radius_m > 0) << test.name;
      for (const float distance : model.distance.distance_m) ASSERT_TRUE(std::isfinite(distance));
    } catch (const InputError&) {
      EXPECT_FALSE(test.has_area) << test.name;
    }
    for (const EdgePoint& point : MakeEdgePoints(test.mesh)) {
      EXPECT_TRUE(point.p_O.allFinite()) << test.name;
      EXPECT_NEAR(point.along_O.norm(), 1, 1e-3) << test.name;
      EXPECT_NEAR(point.normal_1_O.norm(), 1, 1e-3) << test.name;
      EXPECT_NEAR(point.normal_2_O.norm(), 1, 1e-3) << test.name;
    }
    if (!test.has_area) continue;
    const PoseDistance distance(object);
    EXPECT_EQ(distance(Pose::Identity(), Pose::Identity()), 0) << test.name;
    EXPECT_TRUE(std::isfinite(distance(Pose::Identity(), Translation({1, 0, 0})))) << test.name;
    const PoseEmbedding embedding(object);
    EXPECT_TRUE(embedding.Embed(Translation({1, 0, 0})).allFinite()) << test.name;
  }
}

TEST(DegenerateRows, SearchesOfFewOrEqualRowsEnd) {
  for (const int count : {0, 1, 2, 200}) {
    const NeighborIndex index(std::vector<float>(4 * count, 0.5f), 4);
    const std::vector<float> queries(8, 0.25f);
    const Neighbors found = index.Search(queries, 3);
    ASSERT_EQ(found.rows.size(), 6u);
    for (size_t i = 0; i < found.rows.size(); ++i) {
      EXPECT_LT(found.rows[i], count);
      EXPECT_TRUE(found.rows[i] < 0 || std::isfinite(found.squared[i])) << count;
    }
  }
}

TEST(DegenerateVotes, EqualPosesAreOneCluster) {
  const auto object = ObjectOf(BracketMesh());
  const std::vector<PoseDistance> distances = {PoseDistance(*object)};
  EXPECT_TRUE(ClusterVotes({}, distances, 0.1, 10).empty());
  RawHypothesis vote;
  vote.X_CO = BracketPose();
  EXPECT_EQ(ClusterVotes(std::vector<RawHypothesis>(100, vote), distances, 0.1, 10).size(), 1u);
}

}  // namespace
}  // namespace pickbed::tests
