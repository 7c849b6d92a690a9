#include "scenes/mesh_io/mesh_checks.h"

#include <gmock/gmock.h>

#include <limits>

#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TriangleMesh WithUnsharedVertices(const TriangleMesh& mesh) {
  TriangleMesh unshared;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const int first = static_cast<int>(unshared.vertices.size());
    for (const int i : t) unshared.vertices.push_back(mesh.vertices[i]);
    unshared.triangles.emplace_back(first, first + 1, first + 2);
  }
  return unshared;
}

TEST(InspectMesh, MeasuresASoundMesh) {
  const TriangleMesh box = BoxShape({1, 2, 3}, {50, 0, 0});
  for (const TriangleMesh& mesh : {box, WithUnsharedVertices(box)}) {
    const MeshReport report = InspectMesh(mesh);
    EXPECT_TRUE(report.finite);
    EXPECT_EQ(report.triangles, 12);
    EXPECT_TRUE(report.watertight());
    EXPECT_EQ(report.flipped_edges, 0);
    EXPECT_NEAR(report.volume_m3, 6, 1e-9);
  }
}

TEST(InspectMesh, FindsAPlantedHoleAndAFlippedFace) {
  TriangleMesh holed = WithUnsharedVertices(BallShape(1, 2));
  holed.triangles.erase(holed.triangles.begin() + 5);
  EXPECT_EQ(InspectMesh(holed).open_edges, 3);
  EXPECT_FALSE(InspectMesh(holed).watertight());
  TriangleMesh flipped = BallShape(1, 2);
  std::swap(flipped.triangles[7][0], flipped.triangles[7][1]);
  EXPECT_EQ(InspectMesh(flipped).open_edges, 0);
  EXPECT_EQ(InspectMesh(flipped).flipped_edges, 3);
}

TEST(InspectMesh, VolumeOfAnInsideOutMeshIsNegative) {
  TriangleMesh box = BoxShape({1, 1, 1});
  TurnInsideOut(box);
  EXPECT_NEAR(InspectMesh(box).volume_m3, -1, 1e-12);
}

TEST(InspectMesh, ReportsNanVertices) {
  TriangleMesh box = BoxShape({1, 1, 1});
  box.vertices[3].y() = std::nan("");
  EXPECT_FALSE(InspectMesh(box).finite);
}

TEST(RequireUsableMesh, AcceptsOpenThinAndInsideOutMeshes) {
  TriangleMesh inside_out = BoxShape({1, 1, 1}), open = BallShape(0.1, 2);
  TurnInsideOut(inside_out);
  open.triangles.pop_back();
  for (const TriangleMesh& mesh : {inside_out, open, BoxShape({0.3, 0.2, 1e-4})}) {
    EXPECT_NO_THROW(RequireUsableMesh(mesh, "part.obj"));
  }
}

TEST(RequireUsableMesh, ErrorsHoldSourceAndFault) {
  TriangleMesh nan = BoxShape({1, 1, 1}), infinite = nan, no_faces = nan;
  nan.vertices[2].x() = std::nan("");
  infinite.vertices[2].x() = std::numeric_limits<double>::infinity();
  no_faces.triangles.clear();
  struct {
    TriangleMesh mesh;
    const char* text;
  } cases[] = {{nan, "not numbers"},
               {infinite, "not numbers"},
               {no_faces, "no faces"},
               {BoxShape({1, 1, 0}), "no volume"},
               {BoxShape({0, 0, 0}), "no volume"}};
  for (const auto& c : cases) {
    const std::string message = InputErrorOf([&] { RequireUsableMesh(c.mesh, "dir/part.obj"); });
    EXPECT_THAT(message, HasSubstr("'dir/part.obj'"));
    EXPECT_THAT(message, HasSubstr(c.text));
  }
}

TEST(TurnedOutwards, FlipsFacesAndOnlyInwardNormals) {
  const TriangleMesh ball = BallShape(1, 2);
  EXPECT_EQ(TurnedOutwards(ball).triangles, ball.triangles);
  TriangleMesh wrong_faces = ball;
  TurnInsideOut(wrong_faces);
  TriangleMesh wrong_both = wrong_faces;
  for (Eigen::Vector3d& n : wrong_both.normals) n = -n;
  for (const TriangleMesh& wrong : {wrong_faces, wrong_both}) {
    const TriangleMesh right = TurnedOutwards(wrong);
    EXPECT_NEAR(InspectMesh(right).volume_m3, InspectMesh(ball).volume_m3, 1e-12);
    EXPECT_EQ(right.normals, ball.normals);
  }
}

TEST(WithAgreeingFaces, ReversedFacesAreReversedBack) {
  const TriangleMesh ball = BallShape(1, 2);
  TriangleMesh wrong = ball;
  for (size_t i = 0; i < wrong.triangles.size(); i += 5) {
    std::swap(wrong.triangles[i][1], wrong.triangles[i][2]);
  }
  ASSERT_GT(InspectMesh(wrong).flipped_edges, 0);
  const TriangleMesh right = WithAgreeingFaces(wrong);
  EXPECT_EQ(InspectMesh(right).flipped_edges, 0);
  EXPECT_NEAR(InspectMesh(right).volume_m3, InspectMesh(ball).volume_m3, 1e-12);
  EXPECT_TRUE(right.normals.empty());
}

// The cavity of a hollow body points inwards. It has no contradiction and must stay.
TEST(WithAgreeingFaces, GroupsWithoutContradictionStay) {
  TriangleMesh hollow = BallShape(1, 2), cavity = BallShape(0.8, 2);
  TurnInsideOut(cavity);
  Append(cavity, hollow);
  const TriangleMesh same = WithAgreeingFaces(hollow);
  EXPECT_EQ(same.triangles, hollow.triangles);
  EXPECT_EQ(same.normals, hollow.normals);
}

}  // namespace
}  // namespace pickbed::tests
