#pragma once

// Meshes in OpenGL buffers, drawn as instances. Private to .cpp files of sim, see
// sim/render/gl_functions.h. The owner's context must be current in every call.

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/geometry/mesh_levels.h"
#include "scenes/geometry/triangle_mesh.h"
#include "sim/render/gl_functions.h"

namespace pickbed::sim {

// Vertex shader input of one instance, see sim/render/shaders.h.
struct InstanceAttributes {
  std::array<float, 12> X_CO_rows;
  std::array<float, 4> xy_projection;
  std::array<float, 2> z_projection;
  std::array<float, 4> tint_gloss;
  std::array<float, 2> grain;
  uint32_t id;
};

// One level of detail of a mesh.
struct GlMeshLevel {
  double deviation_m = 0;  // largest distance to the original surface
  GLsizei index_count = 0;
  GLenum index_type = GL_UNSIGNED_SHORT;
  GLuint vertex_array = 0;
  GLuint vertices = 0;
  GLuint indices = 0;
};

// An uploaded mesh.
struct GlMesh {
  Bounds bounds_O;
  bool cull_back = false;  // closed and oriented outward, so back faces are never visible
  bool flat = false;       // no vertex normals
  GLuint texture = 0;      // 0 = none
  bool colored_vertices = false;
  std::array<float, 3> base_color{};  // used without texture and vertex colors
  std::vector<GlMeshLevel> levels;    // by increasing deviation, the original first
};

// Uploads all `levels` of detail of `mesh`. `instances` is the buffer of the instance attributes.
GlMesh UploadMesh(const GlFunctions& gl, const TriangleMesh& mesh,
                  const std::vector<MeshLevel>& levels, GLuint instances);
// Frees the buffers and the texture of the mesh.
void DeleteMesh(const GlFunctions& gl, GlMesh& mesh);

// Sets the instance attributes of the bound vertex array to start at instance `first` of the
// buffer.
void BindInstances(const GlFunctions& gl, GLuint instances, size_t first);

}  // namespace pickbed::sim
