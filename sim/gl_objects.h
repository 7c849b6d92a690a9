#pragma once

// Meshes in OpenGL's buffers, drawn as instances. Private to sim's .cpp
// files, see sim/gl_functions.h. Every call needs the owner's context to be current.

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/mesh_levels.h"
#include "scenes/triangle_mesh.h"
#include "sim/gl_functions.h"

namespace pickbed {

// One drawn instance as the vertex shader takes it, see sim/shaders.h.
struct InstanceAttributes {
  std::array<float, 12> X_CO_rows;
  std::array<float, 4> xy_projection;
  std::array<float, 2> z_projection;
  std::array<float, 4> tint_gloss;
  std::array<float, 2> grain;
  uint32_t id;
};

struct GlMeshLevel {
  double deviation_m = 0;  // from the original surface
  GLsizei index_count = 0;
  GLenum index_type = GL_UNSIGNED_SHORT;
  GLuint vertex_array = 0;
  GLuint vertices = 0;
  GLuint indices = 0;
};

struct GlMesh {
  Bounds bounds_O;
  bool cull_back = false;  // closed and facing outward: back faces are never seen
  bool flat = false;       // no vertex normals
  GLuint texture = 0;      // 0 = none
  bool colored_vertices = false;
  std::array<float, 3> base_color{};  // of a mesh with neither
  std::vector<GlMeshLevel> levels;    // by rising deviation, the original first
};

// `levels` are those of `mesh`, `instances` is the buffer that instance attributes come from.
GlMesh UploadMesh(const GlFunctions& gl, const TriangleMesh& mesh,
                  const std::vector<MeshLevel>& levels, GLuint instances);
void DeleteMesh(const GlFunctions& gl, GlMesh& mesh);

// Points the instance attributes of the bound vertex array at instance `first` of the buffer.
void BindInstances(const GlFunctions& gl, GLuint instances, size_t first);

}  // namespace pickbed
