#include "eval/export/scene_glb.h"

#include <gmock/gmock.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "grasp/grippers/table.h"
#include "tests/eval/cube_scenario.h"

namespace pickbed::tests {
namespace {

using testing::ElementsAre;

nlohmann::json JsonOf(const std::string& glb) {
  uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof(length));
  return nlohmann::json::parse(glb.substr(20, length));
}

std::vector<std::string> NodeNames(const nlohmann::json& json) {
  std::vector<std::string> names;
  for (const auto& node : json["nodes"]) names.push_back(node["name"]);
  return names;
}

Scene OneCube() {
  Scene scene;
  scene.objects = {{InstanceId{6}, ObjectId{0}, Translation({0.25, 0.5, 0.125})}};
  return scene;
}

std::vector<HypothesisRecord> OneBelief(double score) {
  HypothesisRecord estimated;
  estimated.score = score;
  estimated.X_WO = Translation({0.25, 0.5, 0.25});
  return {estimated};
}

TEST(SceneGlb, HasTruthHypothesesGripperAndCloudAtTheirPoses) {
  const auto gripper = LoadGripper("jaw_8cm");
  Grasp grasp;
  grasp.X_WG = Translation({0.25, 0.5, 0.75});
  grasp.width_m = 0.03;
  const GlbCloud cloud{"cloud", {{0, 0, 0}, {0, 0, 1}}, {{1, 1, 1}, {1, 0, 0}}};
  const Scene scene = OneCube();
  const auto json =
      JsonOf(SceneGlb({scene, EasyCube(), OneBelief(0.875), &grasp, gripper.get(), &cloud}));
  EXPECT_THAT(NodeNames(json), ElementsAre("world", "bin", "truth 6 cube", "hypothesis 0 cube 0.88",
                                           "hand", "cloud"));
  const auto height_of = [&](int node) { return json["nodes"][node]["matrix"][14]; };
  EXPECT_EQ(height_of(2), 0.125);
  EXPECT_EQ(height_of(3), 0.25);
  EXPECT_EQ(height_of(4), 0.75);
}

TEST(SceneGlb, HasTheProbableAndThePossibleSurfaceOfACompletedSegment) {
  OccupancyShape shape;
  shape.size = 8;
  shape.cell_m = 0.01;
  shape.X_WV = Translation({0.1, 0.2, 0.3});
  shape.occupancy.assign(8 * 8 * 8, 0);
  const auto fill = [&](int low, int high, float p) {
    for (int z = low; z < high; ++z) {
      for (int y = low; y < high; ++y) {
        for (int x = low; x < high; ++x) shape.occupancy[(z * 8 + y) * 8 + x] = p;
      }
    }
  };
  fill(1, 7, 0.35f);
  fill(3, 5, 0.9f);
  OccupancyShape faint = shape;
  for (float& p : faint.occupancy) p = std::min(p, 0.35f);
  const Scene scene = OneCube();
  SceneGlbInput input{scene, EasyCube(), {}};
  input.completed = {shape, faint};
  const auto json = JsonOf(SceneGlb(input));
  EXPECT_THAT(NodeNames(json), ElementsAre("world", "bin", "truth 6 cube", "completed 0",
                                           "possible 0", "possible 1"));
  EXPECT_EQ(json["nodes"][3]["matrix"][14], 0.3f);
}

TEST(SceneGlb, HasNoGripperWithoutAGrasp) {
  const Scene scene = OneCube();
  EXPECT_THAT(NodeNames(JsonOf(SceneGlb({scene, EasyCube(), {}}))),
              ElementsAre("world", "bin", "truth 6 cube"));
}

TEST(SceneGlb, ConfidentHypothesesAreBlueAndUncertainOnesOrange) {
  const Scene scene = OneCube();
  const auto color_of = [&](double score) {
    const auto json = JsonOf(SceneGlb({scene, EasyCube(), OneBelief(score)}));
    return json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"]
        .get<std::vector<float>>();
  };
  EXPECT_GT(color_of(0.95)[2], 3 * color_of(0.95)[0]);
  EXPECT_GT(color_of(0.05)[0], 3 * color_of(0.05)[2]);
  EXPECT_LT(color_of(0.5)[3], 1) << "the ground truth is visible through them";
}

TEST(SceneGlb, LargeMeshesAreSimplified) {
  auto ball = std::make_shared<ObjectModel>(*EasyCube()[0]);
  ball->mesh_O.vertices.clear();
  ball->mesh_O.triangles.clear();
  constexpr int kRings = 60, kSectors = 120;
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int sector = 0; sector < kSectors; ++sector) {
      const double polar = M_PI * ring / kRings, around = 2 * M_PI * sector / kSectors;
      ball->mesh_O.vertices.emplace_back(0.05 * std::sin(polar) * std::cos(around),
                                         0.05 * std::sin(polar) * std::sin(around),
                                         0.05 * std::cos(polar));
      if (ring == kRings) continue;
      const int a = ring * kSectors + sector, b = ring * kSectors + (sector + 1) % kSectors;
      if (ring > 0) ball->mesh_O.triangles.emplace_back(a, a + kSectors, b);
      if (ring + 1 < kRings) ball->mesh_O.triangles.emplace_back(b, a + kSectors, b + kSectors);
    }
  }
  const Scene scene = OneCube();
  const auto faces_with = [&](int max_faces) {
    const auto json = JsonOf(SceneGlb({scene, {ball}, {}}, {.max_faces = max_faces}));
    const auto& primitive = json["meshes"][1]["primitives"][0];
    return json["accessors"][primitive["indices"].get<size_t>()]["count"].get<size_t>() / 3;
  };
  EXPECT_EQ(faces_with(0), ball->mesh_O.triangles.size());
  EXPECT_LE(faces_with(2000), 2000u);
  EXPECT_GE(faces_with(2000), 500u);
}

TEST(ObservedCloud, BackProjectsEachDepthReading) {
  RgbdFrame frame;
  frame.intrinsics = {4, 2, 100, 100, 1.5, 0.5};
  frame.depth_m = Image<float>(4, 2, 0.f);
  frame.depth_m(2, 0) = 0.5f;
  frame.color = Image<Rgb8>(4, 2);
  frame.color(2, 0) = {255, 0, 51};
  const Pose X_WC = LookAt({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  const GlbCloud cloud = ObservedCloud(frame, X_WC, 1);
  ASSERT_EQ(cloud.points_W.size(), 1u) << "0 is no reading";
  const Eigen::Vector3d p_W = X_WC * Eigen::Vector3d(0.5 / 100 * 0.5, -0.5 / 100 * 0.5, 0.5);
  EXPECT_LT((cloud.points_W[0].cast<double>() - p_W).norm(), 1e-6);
  EXPECT_NEAR(cloud.points_W[0].z(), 0.5, 1e-6);
  EXPECT_LT((cloud.rgb[0] - Eigen::Vector3f(1, 0, 0.2f)).norm(), 1e-6f);
  EXPECT_TRUE(ObservedCloud(frame, X_WC, 4).points_W.empty());
  frame.color = {};
  EXPECT_EQ(ObservedCloud(frame, X_WC, 1).rgb.size(), 1u) << "a depth camera without colors";
}

TEST(EstimatedCloud, IsOnTheSurfacesOfTheHypotheses) {
  const auto beliefs = OneBelief(0.9);
  const GlbCloud cloud = EstimatedCloud(EasyCube(), beliefs, 100);
  ASSERT_EQ(cloud.points_W.size(), 100u);
  for (const Eigen::Vector3f& p_W : cloud.points_W) {
    const Eigen::Vector3d p_O = beliefs[0].X_WO.inverse() * p_W.cast<double>();
    EXPECT_NEAR(p_O.cwiseAbs().maxCoeff(), 0.015, 1e-6);
  }
  EXPECT_EQ(EstimatedCloud(EasyCube(), beliefs, 100).points_W, cloud.points_W);
}

}  // namespace
}  // namespace pickbed::tests
