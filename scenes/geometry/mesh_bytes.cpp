#include "scenes/geometry/mesh_bytes.h"

#include <cstring>
#include <vector>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

// Rows without the padding that Eigen's types may have.
template <typename Row>
std::vector<typename Row::Scalar> Flat(const std::vector<Row>& rows) {
  std::vector<typename Row::Scalar> values;
  values.reserve(rows.size() * Row::RowsAtCompileTime);
  for (const Row& row : rows) values.insert(values.end(), row.data(), row.data() + row.size());
  return values;
}

template <typename Row>
std::vector<Row> TakeRows(BlockReader& reader) {
  const std::vector<typename Row::Scalar> values = reader.TakeAll<typename Row::Scalar>();
  constexpr size_t kSize = Row::RowsAtCompileTime;
  CheckInput(values.size() % kSize == 0, "a row is cut short");
  std::vector<Row> rows(values.size() / kSize);
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i] = Eigen::Map<const Row>(values.data() + i * kSize);
  }
  return rows;
}

void CheckConsistency(const TriangleMesh& mesh) {
  const auto count = static_cast<int64_t>(mesh.vertices.size());
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    CheckInput(triangle.minCoeff() >= 0 && triangle.maxCoeff() < count,
               "a triangle has a vertex that does not exist");
  }
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    CheckInput(vertex.allFinite(), "a vertex is not a number or infinite");
  }
  const auto fits = [&](size_t size) { return size == 0 || size == mesh.vertices.size(); };
  CheckInput(fits(mesh.normals.size()) && fits(mesh.uvs.size()) && fits(mesh.colors.size()),
             "normals, uvs or colors do not fit the vertices");
}

}  // namespace

std::string MeshToBytes(const TriangleMesh& mesh) {
  BlockWriter writer;
  writer.Put(Flat(mesh.vertices));
  writer.Put(Flat(mesh.triangles));
  writer.Put(Flat(mesh.normals));
  writer.Put(Flat(mesh.uvs));
  writer.Put(mesh.colors);
  writer.Put(&mesh.base_color, sizeof mesh.base_color);
  writer.Put(std::vector{mesh.texture.width(), mesh.texture.height()});
  writer.Put(mesh.texture.data(), mesh.texture.size() * sizeof(Rgb8));
  return writer.body();
}

TriangleMesh MeshFromBytes(std::string_view bytes) {
  BlockReader reader(bytes);
  TriangleMesh mesh;
  mesh.vertices = TakeRows<Eigen::Vector3d>(reader);
  mesh.triangles = TakeRows<Eigen::Vector3i>(reader);
  mesh.normals = TakeRows<Eigen::Vector3d>(reader);
  mesh.uvs = TakeRows<Eigen::Vector2d>(reader);
  mesh.colors = reader.TakeAll<Rgb8>();
  const std::vector<Rgb8> base = reader.TakeAll<Rgb8>();
  const std::vector<int> size = reader.TakeAll<int>();
  const std::vector<Rgb8> texels = reader.TakeAll<Rgb8>();
  reader.RequireEnd();
  CheckInput(base.size() == 1 && size.size() == 2 && size[0] >= 0 && size[1] >= 0 &&
                 static_cast<int64_t>(size[0]) * size[1] == static_cast<int64_t>(texels.size()),
             "the colors of a mesh are damaged");
  mesh.base_color = base[0];
  if (!texels.empty()) {
    mesh.texture = Image<Rgb8>(size[0], size[1]);
    std::memcpy(mesh.texture.data(), texels.data(), texels.size() * sizeof(Rgb8));
  }
  CheckConsistency(mesh);
  return mesh;
}

}  // namespace pickbed::scenes
