#include "sim/render/gl_objects.h"

#include <cstddef>
#include <cstdint>
#include <limits>

#include "scenes/mesh_io/mesh_checks.h"
#include "sim/render/shaders.h"

namespace pickbed::sim {
namespace {

struct Vertex {
  std::array<float, 3> position;
  std::array<float, 3> normal;
  std::array<float, 2> uv;
  std::array<uint8_t, 4> color;
};

std::vector<Vertex> PackVertices(const TriangleMesh& mesh) {
  std::vector<Vertex> vertices(mesh.vertices.size());
  for (size_t i = 0; i < vertices.size(); ++i) {
    Vertex& v = vertices[i];
    const Eigen::Vector3f p = mesh.vertices[i].cast<float>();
    v.position = {p.x(), p.y(), p.z()};
    if (!mesh.normals.empty()) {
      const Eigen::Vector3f n = mesh.normals[i].cast<float>();
      v.normal = {n.x(), n.y(), n.z()};
    }
    if (!mesh.uvs.empty()) {
      const Eigen::Vector2f uv = mesh.uvs[i].cast<float>();
      v.uv = {uv.x(), uv.y()};
    }
    const Rgb8 c = mesh.colors.empty() ? mesh.base_color : mesh.colors[i];
    v.color = {c.r, c.g, c.b, 255};
  }
  return vertices;
}

void VertexAttribute(const GlFunctions& gl, GLuint location, int size, GLenum type, bool normalized,
                     size_t offset) {
  gl.EnableVertexAttribArray(location);
  gl.VertexAttribPointer(location, size, type, normalized, sizeof(Vertex),
                         reinterpret_cast<const void*>(offset));
}

template <typename Index>
void UploadIndices(const GlFunctions& gl, const TriangleMesh& mesh) {
  std::vector<Index> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) indices.push_back(static_cast<Index>(t[k]));
  }
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, indices.size() * sizeof(Index), indices.data(),
                GL_STATIC_DRAW);
}

GlMeshLevel UploadLevel(const GlFunctions& gl, const MeshLevel& level, GLuint instances) {
  const TriangleMesh& mesh = level.mesh;
  GlMeshLevel out;
  out.deviation_m = level.deviation_m;
  out.index_count = static_cast<GLsizei>(3 * mesh.triangles.size());
  gl.GenVertexArrays(1, &out.vertex_array);
  gl.BindVertexArray(out.vertex_array);

  const std::vector<Vertex> vertices = PackVertices(mesh);
  gl.GenBuffers(1, &out.vertices);
  gl.BindBuffer(GL_ARRAY_BUFFER, out.vertices);
  gl.BufferData(GL_ARRAY_BUFFER, vertices.size() * sizeof(Vertex), vertices.data(), GL_STATIC_DRAW);
  VertexAttribute(gl, kPositionAttribute, 3, GL_FLOAT, false, offsetof(Vertex, position));
  VertexAttribute(gl, kNormalAttribute, 3, GL_FLOAT, false, offsetof(Vertex, normal));
  VertexAttribute(gl, kUvAttribute, 2, GL_FLOAT, false, offsetof(Vertex, uv));
  VertexAttribute(gl, kColorAttribute, 4, GL_UNSIGNED_BYTE, true, offsetof(Vertex, color));

  gl.GenBuffers(1, &out.indices);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, out.indices);
  if (mesh.vertices.size() <= std::numeric_limits<uint16_t>::max()) {
    UploadIndices<uint16_t>(gl, mesh);
  } else {
    out.index_type = GL_UNSIGNED_INT;
    UploadIndices<uint32_t>(gl, mesh);
  }
  BindInstances(gl, instances, 0);
  for (GLuint i = 0; i < kInstanceAttributeCount; ++i) {
    gl.EnableVertexAttribArray(kFirstInstanceAttribute + i);
    gl.VertexAttribDivisor(kFirstInstanceAttribute + i, 1);
  }
  gl.BindVertexArray(0);
  return out;
}

// The first row of the image is the first row of the texture, because uvs have v = 0 at the top.
GLuint UploadTexture(const GlFunctions& gl, const Image<Rgb8>& image) {
  GLuint texture = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image.width(), image.height(), 0, GL_RGB,
                GL_UNSIGNED_BYTE, image.data());
  gl.GenerateMipmap(GL_TEXTURE_2D);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

}  // namespace

GlMesh UploadMesh(const GlFunctions& gl, const TriangleMesh& mesh,
                  const std::vector<MeshLevel>& levels, GLuint instances) {
  GlMesh out;
  out.bounds_O = MeshBounds(mesh);
  const MeshReport report = InspectMesh(mesh);
  out.cull_back = report.watertight() && report.volume_m3 > 0;
  out.flat = mesh.normals.empty();
  out.colored_vertices = !mesh.colors.empty();
  const Rgb8 c = mesh.base_color;
  out.base_color = {c.r / 255.0f, c.g / 255.0f, c.b / 255.0f};
  for (const MeshLevel& level : levels) {
    out.levels.push_back(UploadLevel(gl, level, instances));
  }
  if (!mesh.texture.empty() && !mesh.uvs.empty()) out.texture = UploadTexture(gl, mesh.texture);
  return out;
}

void DeleteMesh(const GlFunctions& gl, GlMesh& mesh) {
  for (GlMeshLevel& level : mesh.levels) {
    gl.DeleteVertexArrays(1, &level.vertex_array);
    gl.DeleteBuffers(1, &level.vertices);
    gl.DeleteBuffers(1, &level.indices);
  }
  if (mesh.texture) gl.DeleteTextures(1, &mesh.texture);
}

void BindInstances(const GlFunctions& gl, GLuint instances, size_t first) {
  gl.BindBuffer(GL_ARRAY_BUFFER, instances);
  const size_t base = first * sizeof(InstanceAttributes);
  const auto attribute = [&](GLuint index, int size, size_t offset) {
    gl.VertexAttribPointer(kFirstInstanceAttribute + index, size, GL_FLOAT, false,
                           sizeof(InstanceAttributes),
                           reinterpret_cast<const void*>(base + offset));
  };
  for (GLuint row = 0; row < 3; ++row) {
    attribute(row, 4, offsetof(InstanceAttributes, X_CO_rows) + 4 * sizeof(float) * row);
  }
  attribute(3, 4, offsetof(InstanceAttributes, xy_projection));
  attribute(4, 2, offsetof(InstanceAttributes, z_projection));
  attribute(5, 4, offsetof(InstanceAttributes, tint_gloss));
  attribute(6, 2, offsetof(InstanceAttributes, grain));
  gl.VertexAttribIPointer(kFirstInstanceAttribute + 7, 1, GL_UNSIGNED_INT,
                          sizeof(InstanceAttributes),
                          reinterpret_cast<const void*>(base + offsetof(InstanceAttributes, id)));
}

}  // namespace pickbed::sim
