#pragma once

// GLSL 3.30 of the renderer, as text. The C++ side puts "#version" and these switches before it:
//   COLOR    write colour (else depth and ids alone)
//   TEXTURE  colour from a texture instead of the vertices
//   FLAT     no vertex normals: take the face's from screen derivatives

namespace pickbed {

// Attribute locations, shared with sim/gl_objects.cpp.
enum ShaderAttribute : unsigned {
  kPositionAttribute = 0,
  kNormalAttribute = 1,
  kColorAttribute = 2,
  kUvAttribute = 3,
  kFirstInstanceAttribute = 4,  // rows 0..2 of X_CO, xy projection, z projection, light, id
  kInstanceAttributeCount = 7,
};

// Everything is drawn upside down in OpenGL's sense (clip y follows image v), so that the first row
// that is read back is the top row of the image.
inline constexpr const char* kVertexShader = R"glsl(
layout(location = 0) in vec3 position_O;
layout(location = 4) in vec4 X_CO_row0;
layout(location = 5) in vec4 X_CO_row1;
layout(location = 6) in vec4 X_CO_row2;
layout(location = 7) in vec4 xy_projection;  // clip x = [0] x + [1] z, clip y = [2] y + [3] z
layout(location = 8) in vec2 z_projection;   // clip z = [0] z + [1]
layout(location = 10) in uint instance_id;
flat out uint id;
out float depth_m;
#ifdef COLOR
layout(location = 9) in vec3 instance_light_C;
flat out vec3 light_C;
out vec3 position_C;
#ifdef TEXTURE
layout(location = 3) in vec2 vertex_uv;
out vec2 uv;
#else
layout(location = 2) in vec3 vertex_color;
out vec3 color;
#endif
#ifndef FLAT
layout(location = 1) in vec3 normal_O;
out vec3 normal_C;
#endif
#endif

void main() {
  vec4 p_O = vec4(position_O, 1.0);
  vec3 p_C = vec3(dot(X_CO_row0, p_O), dot(X_CO_row1, p_O), dot(X_CO_row2, p_O));
  gl_Position = vec4(xy_projection[0] * p_C.x + xy_projection[1] * p_C.z,
                     xy_projection[2] * p_C.y + xy_projection[3] * p_C.z,
                     z_projection[0] * p_C.z + z_projection[1], p_C.z);
  id = instance_id;
  depth_m = p_C.z;
#ifdef COLOR
  light_C = instance_light_C;
  position_C = p_C;
#ifdef TEXTURE
  uv = vertex_uv;
#else
  color = vertex_color;
#endif
#ifndef FLAT
  normal_C = vec3(dot(X_CO_row0.xyz, normal_O), dot(X_CO_row1.xyz, normal_O),
                  dot(X_CO_row2.xyz, normal_O));
#endif
#endif
}
)glsl";

// Lambert's law for one point light and both sides of a face.
inline constexpr const char* kFragmentShader = R"glsl(
flat in uint id;
in float depth_m;
layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_id;
#ifdef COLOR
layout(location = 2) out vec4 out_color;
flat in vec3 light_C;
uniform vec2 ambient_diffuse;
in vec3 position_C;
#ifdef TEXTURE
uniform sampler2D surface;
in vec2 uv;
#else
in vec3 color;
#endif
#ifndef FLAT
in vec3 normal_C;
#endif
#endif

void main() {
  out_depth_m = depth_m;
  out_id = id;
#ifdef COLOR
#ifdef FLAT
  vec3 normal = normalize(cross(dFdx(position_C), dFdy(position_C)));
#else
  vec3 normal = normalize(normal_C);
#endif
  if (dot(normal, position_C) > 0.0) normal = -normal;
  float cosine = max(dot(normal, normalize(light_C - position_C)), 0.0);
#ifdef TEXTURE
  vec3 albedo = texture(surface, uv).rgb;
#else
  vec3 albedo = color;
#endif
  out_color = vec4(albedo * (ambient_diffuse.x + ambient_diffuse.y * cosine), 1.0);
#endif
}
)glsl";

}  // namespace pickbed
