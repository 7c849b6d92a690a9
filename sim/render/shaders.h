#pragma once

// GLSL 3.30 source of the renderer's shaders. The C++ side puts "#version" and these switches
// before it:
//   COLOR        write color
//   IDS          write instance ids
//   NORMALS      write normals in the camera frame, towards the camera
//   COORDINATES  write the visible point in the object's frame
//   COVERAGE     write one at each covered pixel, and nothing else
//   TEXTURE      color from a texture instead of one for the whole mesh
//   VERTEX_COLOR color from the vertices
//   FLAT         no vertex normals: compute the face's from screen derivatives
//   MATERIAL     tint, gloss and grain of each instance
//   SHADOW       read a shadow map
//   SHADOW_MAP   depth only, as seen from the light, to make a shadow map
// Depth is written unless COVERAGE or SHADOW_MAP is set. In llvmpipe, each value passed from vertex
// to fragment shader makes triangles slower. So each exists only under the switch that needs it.
// Depth needs none, because 1 / gl_FragCoord.w is clip w.

#include "sim/layer.h"

namespace pickbed::sim {

// Attribute locations, shared with sim/render/gl_objects.cpp.
enum ShaderAttribute : unsigned {
  kPositionAttribute = 0,
  kNormalAttribute = 1,
  kColorAttribute = 2,
  kUvAttribute = 3,
  kFirstInstanceAttribute =
      4,  // rows 0..2 of X_CO, xy projection, z projection, tint and gloss, grain, id
  kInstanceAttributeCount = 8,
};

// Images are drawn upside down in OpenGL's sense: clip y follows image v. So the first row read
// back is the top row of the image.
inline constexpr const char* kVertexShader = R"glsl(
layout(location = 0) in vec3 position_O;
layout(location = 4) in vec4 X_CO_row0;
layout(location = 5) in vec4 X_CO_row1;
layout(location = 6) in vec4 X_CO_row2;
layout(location = 7) in vec4 xy_projection;  // clip x = [0] x + [1] z, clip y = [2] y + [3] z
layout(location = 8) in vec2 z_projection;   // clip z = [0] z + [1]
#ifdef IDS
layout(location = 11) in uint instance_id;
flat out uint id;
#endif
#if defined(COLOR) || defined(NORMALS)
out vec3 position_C;
#ifndef FLAT
layout(location = 1) in vec3 normal_O;
out vec3 normal_C;
#endif
#endif
#if defined(COORDINATES) || (defined(COLOR) && defined(MATERIAL))
out vec3 coordinates_O;
#endif
#ifdef COLOR
#ifdef MATERIAL
layout(location = 9) in vec4 instance_tint;    // rgb, gloss
layout(location = 10) in vec2 instance_grain;  // depth of the pattern 0..1, cells a metre
flat out vec4 tint;
flat out vec2 grain;
#endif
#ifdef TEXTURE
layout(location = 3) in vec2 vertex_uv;
out vec2 uv;
#elif defined(VERTEX_COLOR)
layout(location = 2) in vec3 vertex_color;
out vec3 color;
#endif
#endif

void main() {
  vec4 p_O = vec4(position_O, 1.0);
  vec3 p_C = vec3(dot(X_CO_row0, p_O), dot(X_CO_row1, p_O), dot(X_CO_row2, p_O));
  gl_Position = vec4(xy_projection[0] * p_C.x + xy_projection[1] * p_C.z,
                     xy_projection[2] * p_C.y + xy_projection[3] * p_C.z,
                     z_projection[0] * p_C.z + z_projection[1], p_C.z);
#ifdef IDS
  id = instance_id;
#endif
#if defined(COLOR) || defined(NORMALS)
  position_C = p_C;
#ifndef FLAT
  normal_C = vec3(dot(X_CO_row0.xyz, normal_O), dot(X_CO_row1.xyz, normal_O),
                  dot(X_CO_row2.xyz, normal_O));
#endif
#endif
#if defined(COORDINATES) || (defined(COLOR) && defined(MATERIAL))
  coordinates_O = position_O;
#endif
#ifdef COLOR
#ifdef MATERIAL
  tint = instance_tint;
  grain = instance_grain;
#endif
#ifdef TEXTURE
  uv = vertex_uv;
#elif defined(VERTEX_COLOR)
  color = vertex_color;
#endif
#endif
}
)glsl";

// Lambertian shading with one point light on both sides of a face. Materials with gloss also get
// Blinn's highlight ("Models of Light Reflection for Computer Synthesized Pictures", SIGGRAPH
// 1977).
inline constexpr const char* kFragmentShader = R"glsl(
#ifdef COVERAGE
layout(location = 0) out float out_coverage;
#elif !defined(SHADOW_MAP)
layout(location = 0) out float out_depth_m;
#endif
#ifdef IDS
flat in uint id;
layout(location = 1) out uint out_id;
#endif
#if defined(COLOR) || defined(NORMALS)
in vec3 position_C;
#ifndef FLAT
in vec3 normal_C;
#endif
#endif
#if defined(COORDINATES) || (defined(COLOR) && defined(MATERIAL))
in vec3 coordinates_O;
#endif
#ifdef NORMALS
layout(location = 3) out vec4 out_normal_C;
#endif
#ifdef COORDINATES
layout(location = 4) out vec4 out_coordinates_O;
#endif
#ifdef COLOR
layout(location = 2) out vec4 out_color;
uniform vec3 light_C;
uniform vec2 ambient_diffuse;
#ifdef TEXTURE
uniform sampler2D surface;
in vec2 uv;
#elif defined(VERTEX_COLOR)
in vec3 color;
#else
uniform vec3 color;
#endif
#ifdef MATERIAL
flat in vec4 tint;
flat in vec2 grain;

float Hash(ivec3 cell) {
  uint h = uint(cell.x) * 73856093u ^ uint(cell.y) * 19349663u ^ uint(cell.z) * 83492791u;
  h = (h ^ (h >> 13)) * 1274126177u;
  return float((h ^ (h >> 16)) & 65535u) / 65535.0;
}

// Value noise of one octave: random at the corners of cells, smooth in between.
float Noise(vec3 p) {
  ivec3 c = ivec3(floor(p));
  vec3 f = p - floor(p);
  f = f * f * (3.0 - 2.0 * f);
  vec4 low = vec4(Hash(c), Hash(c + ivec3(1, 0, 0)), Hash(c + ivec3(0, 1, 0)),
                  Hash(c + ivec3(1, 1, 0)));
  vec4 high = vec4(Hash(c + ivec3(0, 0, 1)), Hash(c + ivec3(1, 0, 1)), Hash(c + ivec3(0, 1, 1)),
                   Hash(c + ivec3(1, 1, 1)));
  vec4 z = mix(low, high, f.z);
  vec2 y = mix(z.xy, z.zw, f.y);
  return mix(y.x, y.y, f.x);
}
#endif
#ifdef SHADOW
uniform mat4 shadow_from_C;  // to the shadow map's texture coordinates and depth
uniform vec2 shadow_blur;    // half width of the filter in texture coordinates, way out in m
uniform sampler2DShadow shadow_map;

// Share of the light that arrives: percentage-closer filtering of 4 x 4 taps (Reeves, Salesin and
// Cook, "Rendering Antialiased Shadows with Depth Maps", SIGGRAPH 1987).
float Lit(vec3 p_C) {
  vec4 p = shadow_from_C * vec4(p_C, 1.0);
  if (p.w <= 0.0) return 1.0;
  vec3 at = p.xyz / p.w;
  float sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      sum += texture(shadow_map, vec3(at.xy + (vec2(i, j) / 1.5 - 1.0) * shadow_blur.x, at.z));
    }
  }
  return sum / 16.0;
}
#endif
#endif

void main() {
#ifdef COVERAGE
  out_coverage = 1.0;
#elif !defined(SHADOW_MAP)
  out_depth_m = 1.0 / gl_FragCoord.w;
#endif
#ifdef IDS
  out_id = id;
#endif
#if defined(COLOR) || defined(NORMALS)
#ifdef FLAT
  vec3 normal = cross(dFdx(position_C), dFdy(position_C));
#else
  vec3 normal = normal_C;
#endif
  if (dot(normal, position_C) > 0.0) normal = -normal;
#if defined(NORMALS) || defined(MATERIAL) || defined(SHADOW)
  normal = normalize(normal);
#endif
#endif
#ifdef NORMALS
  out_normal_C = vec4(normal, 1.0);
#endif
#ifdef COORDINATES
  out_coordinates_O = vec4(coordinates_O, 1.0);
#endif
#ifdef COLOR
  vec3 to_light = light_C - position_C;
  float cosine = max(dot(normal, to_light), 0.0) *
                 inversesqrt(dot(normal, normal) * dot(to_light, to_light));
#ifdef TEXTURE
  vec3 albedo = texture(surface, uv).rgb;
#else
  vec3 albedo = color;
#endif
#ifdef MATERIAL
  albedo *= tint.rgb * (1.0 - grain.x * Noise(coordinates_O * grain.y));
#endif
#ifdef SHADOW
  float direct = ambient_diffuse.y * Lit(position_C + shadow_blur.y * normal);
#else
  float direct = ambient_diffuse.y;
#endif
  vec3 shade = albedo * (ambient_diffuse.x + direct * cosine);
#ifdef MATERIAL
  float halfway = max(dot(normal, normalize(normalize(to_light) - normalize(position_C))), 0.0);
  shade += direct * tint.a * pow(halfway, 40.0);
#endif
  out_color = vec4(shade, 1.0);
#endif
}
)glsl";

}  // namespace pickbed::sim
