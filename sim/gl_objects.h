#pragma once

// What the renderer keeps in OpenGL: meshes, framebuffers and programs. Private to sim's .cpp
// files, see sim/gl_functions.h. Every call needs the owner's context to be current.

#include <array>
#include <cstdint>
#include <vector>

#include "scenes/triangle_mesh.h"
#include "sim/gl_functions.h"

namespace pickbed {

// One drawn instance as the vertex shader takes it, see sim/shaders.h.
struct InstanceAttributes {
  std::array<float, 12> X_CO_rows;
  std::array<float, 4> xy_projection;
  std::array<float, 2> z_projection;
  std::array<float, 3> light_C;
  uint32_t id;
};

struct GlMeshLevel {
  double deviation_m = 0;  // from the original surface
  GLsizei index_count = 0;
  GLuint vertex_array = 0;
  GLuint vertices = 0;
  GLuint indices = 0;
};

struct GlMesh {
  Bounds bounds_O;
  bool cull_back = false;           // closed and facing outward: back faces are never seen
  bool flat = false;                // no vertex normals
  GLuint texture = 0;               // 0 = colours of the vertices
  std::vector<GlMeshLevel> levels;  // by rising deviation, the original first
};

// `instances` is the buffer that instance attributes come from.
GlMesh UploadMesh(const GlFunctions& gl, const TriangleMesh& mesh, GLuint instances);
void DeleteMesh(const GlFunctions& gl, GlMesh& mesh);

// Points the instance attributes of the bound vertex array at instance `first` of the buffer.
void BindInstances(const GlFunctions& gl, GLuint instances, size_t first);

// A framebuffer with metric depth (R32F), ids (R16UI) and colour (RGBA8).
struct GlTarget {
  int width = 0;
  int height = 0;
  GLuint framebuffer = 0;
  std::array<GLuint, 4> renderbuffers{};  // depth in metres, ids, colour, depth buffer
};
inline constexpr GLenum kDepthAttachment = GL_COLOR_ATTACHMENT0;
inline constexpr GLenum kIdAttachment = GL_COLOR_ATTACHMENT1;
inline constexpr GLenum kColorAttachment = GL_COLOR_ATTACHMENT2;

// Throws std::runtime_error when the driver refuses the size.
GlTarget MakeTarget(const GlFunctions& gl, int width, int height);
void DeleteTarget(const GlFunctions& gl, GlTarget& target);
// Binds it, chooses what is drawn, and clears that to zero (far for the depth buffer).
void BeginTarget(const GlFunctions& gl, const GlTarget& target, bool with_color);

struct GlProgram {
  GLuint program = 0;
  GLint ambient_diffuse = -1;
};

// Throws std::logic_error with the compiler's log.
GlProgram MakeProgram(const GlFunctions& gl, bool color, bool texture, bool flat);

}  // namespace pickbed
