// Tests SaveObj of mesh_io.h with LoadMesh.

#include <gmock/gmock.h>

#include "scenes/mesh_io/mesh_io.h"
#include "tests/scenes/shapes.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

// Compares geometry and attributes corner by corner. Vertex indices may differ.
void ExpectSameSurface(const TriangleMesh& a, const TriangleMesh& b, double tolerance) {
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  ASSERT_EQ(a.normals.empty(), b.normals.empty());
  ASSERT_EQ(a.uvs.empty(), b.uvs.empty());
  ASSERT_EQ(a.colors.empty(), b.colors.empty());
  for (size_t i = 0; i < a.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int va = a.triangles[i][k], vb = b.triangles[i][k];
      ASSERT_LT((a.vertices[va] - b.vertices[vb]).cwiseAbs().maxCoeff(), tolerance);
      if (!a.normals.empty()) {
        ASSERT_LT((a.normals[va] - b.normals[vb]).norm(), 1e-6);
      }
      if (!a.uvs.empty()) {
        ASSERT_LT((a.uvs[va] - b.uvs[vb]).norm(), 1e-6);
      }
      if (!a.colors.empty()) {
        ASSERT_EQ(a.colors[va], b.colors[vb]);
      }
    }
  }
}

TEST(SaveObj, RoundTripsGeometryAndAttributes) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "part.obj";
  const TriangleMesh plain = BoxShape({0.05, 0.03, 0.02}, {0.01, 0, 0}),
                     smooth = BallShape(0.04, 3);
  TriangleMesh colored = smooth, painted = smooth, textured = smooth;
  for (size_t i = 0; i < smooth.vertices.size(); ++i) {
    colored.colors.push_back({static_cast<uint8_t>(i), 7, static_cast<uint8_t>(255 - i % 256)});
    textured.uvs.emplace_back(0.5 + 0.4 * smooth.normals[i].x(), 0.5 + 0.3 * smooth.normals[i].y());
  }
  painted.base_color = {200, 30, 40};
  textured.texture = FourColors();
  textured.base_color = {255, 255, 255};
  for (const TriangleMesh& mesh : {plain, smooth, colored, painted, textured}) {
    SaveObj(path, mesh);
    const TriangleMesh loaded = LoadMesh(path);
    ExpectSameSurface(mesh, loaded, 5e-9);  // half a step of a float at 0.05 m, and of 10 decimals
    EXPECT_EQ(loaded.texture, mesh.texture);
    EXPECT_EQ(loaded.base_color, mesh.base_color);
    // A loaded mesh is written and read again without any change.
    SaveObj(path, loaded);
    const TriangleMesh again = LoadMesh(path);
    EXPECT_EQ(MeshHash(again), MeshHash(loaded));
    ExpectSameSurface(loaded, again, 1e-300);
    std::filesystem::remove(folder.path() / "part.mtl");
  }
}

TEST(SaveObj, BytesAreReproducibleAndMinimal) {
  const TemporaryFolder folder;
  const TriangleMesh ball = BallShape(0.04, 2);
  SaveObj(folder.path() / "a.obj", ball);
  SaveObj(folder.path() / "b.obj", ball);
  EXPECT_EQ(ReadFileBytes(folder.path() / "a.obj"), ReadFileBytes(folder.path() / "b.obj"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a.mtl"));
  TriangleMesh point = BoxShape({1, 1, 1});
  point.vertices[0] = {-0.0, 1e-12, -2.5e-5};
  SaveObj(folder.path() / "c.obj", point);
  EXPECT_THAT(ReadFileBytes(folder.path() / "c.obj"), testing::StartsWith("v 0 0 -0.000025\n"));
  EXPECT_THAT(InputErrorOf([&] { SaveObj(folder.path() / "no" / "a.obj", ball); }),
              HasSubstr("a.obj': No such file"));
}

}  // namespace
}  // namespace pickbed::tests
