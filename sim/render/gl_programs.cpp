#include "sim/render/gl_programs.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "sim/render/shaders.h"

namespace pickbed::sim {
namespace {

constexpr std::pair<unsigned, const char*> kSwitchNames[] = {
    {kColorSwitch, "COLOR"},
    {kIdsSwitch, "IDS"},
    {kNormalsSwitch, "NORMALS"},
    {kCoordinatesSwitch, "COORDINATES"},
    {kCoverageSwitch, "COVERAGE"},
    {kTextureSwitch, "TEXTURE"},
    {kFlatSwitch, "FLAT"},
    {kMaterialSwitch, "MATERIAL"},
    {kShadowSwitch, "SHADOW"},
    {kShadowMapSwitch, "SHADOW_MAP"},
    {kVertexColorSwitch, "VERTEX_COLOR"},
};

GLuint CompileShader(const GlFunctions& gl, GLenum type, const std::string& source) {
  const GLuint shader = gl.CreateShader(type);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint ok = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (!ok) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
    throw std::logic_error("shader does not compile: " + log.substr(0, length));
  }
  return shader;
}

GlProgram MakeProgram(const GlFunctions& gl, unsigned switches) {
  std::string head = "#version 330 core\n";
  for (const auto& [bit, name] : kSwitchNames) {
    if (switches & bit) head += std::string("#define ") + name + "\n";
  }
  const GLuint vertex = CompileShader(gl, GL_VERTEX_SHADER, head + kVertexShader);
  const GLuint fragment = CompileShader(gl, GL_FRAGMENT_SHADER, head + kFragmentShader);
  GlProgram out;
  out.program = gl.CreateProgram();
  gl.AttachShader(out.program, vertex);
  gl.AttachShader(out.program, fragment);
  gl.LinkProgram(out.program);
  gl.DeleteShader(vertex);
  gl.DeleteShader(fragment);
  GLint ok = 0;
  gl.GetProgramiv(out.program, GL_LINK_STATUS, &ok);
  if (!ok) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    gl.GetProgramInfoLog(out.program, static_cast<GLsizei>(log.size()), &length, log.data());
    throw std::logic_error("shaders do not link: " + log.substr(0, length));
  }
  out.light_C = gl.GetUniformLocation(out.program, "light_C");
  out.ambient_diffuse = gl.GetUniformLocation(out.program, "ambient_diffuse");
  out.color = gl.GetUniformLocation(out.program, "color");
  out.shadow_from_C = gl.GetUniformLocation(out.program, "shadow_from_C");
  out.shadow_blur = gl.GetUniformLocation(out.program, "shadow_blur");
  // Texture unit 0 has the surface texture, unit 1 the shadow map.
  if (const GLint map = gl.GetUniformLocation(out.program, "shadow_map"); map >= 0) {
    gl.UseProgram(out.program);
    gl.Uniform1i(map, 1);
  }
  return out;
}

}  // namespace

const GlProgram& GlPrograms::Of(const GlFunctions& gl, unsigned switches) {
  auto found = programs_.find(switches);
  if (found == programs_.end()) {
    found = programs_.emplace(switches, MakeProgram(gl, switches)).first;
  }
  return found->second;
}

void GlPrograms::DeleteAll(const GlFunctions& gl) {
  for (auto& [switches, program] : programs_) gl.DeleteProgram(program.program);
  programs_.clear();
}

}  // namespace pickbed::sim
