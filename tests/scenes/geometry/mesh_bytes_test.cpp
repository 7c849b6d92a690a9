#include "scenes/geometry/mesh_bytes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

TriangleMesh Example() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.normals.assign(3, Eigen::Vector3d::UnitZ());
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  mesh.base_color = {10, 11, 12};
  mesh.texture = Image<Rgb8>(2, 1);
  mesh.texture(1, 0) = {13, 14, 15};
  return mesh;
}

TEST(MeshBytes, RoundTripKeepsAllMembers) {
  const TriangleMesh mesh = Example(), read = MeshFromBytes(MeshToBytes(mesh));
  EXPECT_EQ(read.vertices, mesh.vertices);
  EXPECT_EQ(read.triangles, mesh.triangles);
  EXPECT_EQ(read.normals, mesh.normals);
  EXPECT_EQ(read.uvs, mesh.uvs);
  EXPECT_EQ(read.colors, mesh.colors);
  EXPECT_EQ(read.base_color, mesh.base_color);
  ASSERT_EQ(read.texture.width(), 2);
  EXPECT_EQ(read.texture(1, 0), mesh.texture(1, 0));
  EXPECT_EQ(MeshToBytes(MeshFromBytes(MeshToBytes(TriangleMesh()))), MeshToBytes(TriangleMesh()));
}

TEST(MeshBytes, InconsistentMeshesAreRefused) {
  const auto error_of = [](const TriangleMesh& mesh) {
    return ErrorOf([&] { MeshFromBytes(MeshToBytes(mesh)); });
  };
  TriangleMesh mesh = Example();
  mesh.triangles[0].x() = 3;
  EXPECT_THAT(error_of(mesh), HasSubstr("a vertex that does not exist"));
  mesh.triangles[0].x() = -1;
  EXPECT_THAT(error_of(mesh), HasSubstr("a vertex that does not exist"));
  mesh = Example();
  mesh.vertices[1].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of(mesh), HasSubstr("is not a number or infinite"));
  mesh = Example();
  mesh.colors.pop_back();
  EXPECT_THAT(error_of(mesh), HasSubstr("do not fit the vertices"));
}

TEST(MeshBytes, EveryCutAndBytesAfterTheEndAreRefused) {
  const std::string bytes = MeshToBytes(Example());
  EXPECT_NE(ErrorOf([&] { MeshFromBytes(bytes + "x"); }), "no error");
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_NE(ErrorOf([&] { MeshFromBytes(bytes.substr(0, size)); }), "no error") << size;
  }
}

}  // namespace
}  // namespace pickbed::tests
