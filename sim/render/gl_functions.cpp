#include "sim/render/gl_functions.h"

#include <stdexcept>

namespace pickbed::sim {
namespace {

template <typename F>
void Load(GlContext& context, const char* name, F& function) {
  function = reinterpret_cast<F>(context.GetProcAddress(name));
  if (!function) throw std::runtime_error(context.Name() + " has no function " + name);
}

}  // namespace

GlFunctions LoadGlFunctions(GlContext& context) {
  GlFunctions gl;
  Load(context, "glActiveTexture", gl.ActiveTexture);
  Load(context, "glAttachShader", gl.AttachShader);
  Load(context, "glBindBuffer", gl.BindBuffer);
  Load(context, "glBindFramebuffer", gl.BindFramebuffer);
  Load(context, "glBindRenderbuffer", gl.BindRenderbuffer);
  Load(context, "glBindTexture", gl.BindTexture);
  Load(context, "glBindVertexArray", gl.BindVertexArray);
  Load(context, "glBufferData", gl.BufferData);
  Load(context, "glCheckFramebufferStatus", gl.CheckFramebufferStatus);
  Load(context, "glClearBufferfv", gl.ClearBufferfv);
  Load(context, "glClearBufferuiv", gl.ClearBufferuiv);
  Load(context, "glCompileShader", gl.CompileShader);
  Load(context, "glCreateProgram", gl.CreateProgram);
  Load(context, "glCreateShader", gl.CreateShader);
  Load(context, "glDeleteBuffers", gl.DeleteBuffers);
  Load(context, "glDeleteFramebuffers", gl.DeleteFramebuffers);
  Load(context, "glDeleteProgram", gl.DeleteProgram);
  Load(context, "glDeleteRenderbuffers", gl.DeleteRenderbuffers);
  Load(context, "glDeleteShader", gl.DeleteShader);
  Load(context, "glDeleteTextures", gl.DeleteTextures);
  Load(context, "glDeleteVertexArrays", gl.DeleteVertexArrays);
  Load(context, "glDepthFunc", gl.DepthFunc);
  Load(context, "glDisable", gl.Disable);
  Load(context, "glDrawBuffers", gl.DrawBuffers);
  Load(context, "glDrawElementsInstanced", gl.DrawElementsInstanced);
  Load(context, "glEnable", gl.Enable);
  Load(context, "glEnableVertexAttribArray", gl.EnableVertexAttribArray);
  Load(context, "glFramebufferRenderbuffer", gl.FramebufferRenderbuffer);
  Load(context, "glFramebufferTexture2D", gl.FramebufferTexture2D);
  Load(context, "glFrontFace", gl.FrontFace);
  Load(context, "glGenBuffers", gl.GenBuffers);
  Load(context, "glGenerateMipmap", gl.GenerateMipmap);
  Load(context, "glGenFramebuffers", gl.GenFramebuffers);
  Load(context, "glGenRenderbuffers", gl.GenRenderbuffers);
  Load(context, "glGenTextures", gl.GenTextures);
  Load(context, "glGenVertexArrays", gl.GenVertexArrays);
  Load(context, "glGetError", gl.GetError);
  Load(context, "glGetProgramInfoLog", gl.GetProgramInfoLog);
  Load(context, "glGetProgramiv", gl.GetProgramiv);
  Load(context, "glGetShaderInfoLog", gl.GetShaderInfoLog);
  Load(context, "glGetShaderiv", gl.GetShaderiv);
  Load(context, "glGetUniformLocation", gl.GetUniformLocation);
  Load(context, "glLinkProgram", gl.LinkProgram);
  Load(context, "glPixelStorei", gl.PixelStorei);
  Load(context, "glReadBuffer", gl.ReadBuffer);
  Load(context, "glReadPixels", gl.ReadPixels);
  Load(context, "glRenderbufferStorage", gl.RenderbufferStorage);
  Load(context, "glScissor", gl.Scissor);
  Load(context, "glShaderSource", gl.ShaderSource);
  Load(context, "glTexImage2D", gl.TexImage2D);
  Load(context, "glTexParameteri", gl.TexParameteri);
  Load(context, "glUniform1i", gl.Uniform1i);
  Load(context, "glUniform2f", gl.Uniform2f);
  Load(context, "glUniform3f", gl.Uniform3f);
  Load(context, "glUniformMatrix4fv", gl.UniformMatrix4fv);
  Load(context, "glUseProgram", gl.UseProgram);
  Load(context, "glVertexAttribDivisor", gl.VertexAttribDivisor);
  Load(context, "glVertexAttribIPointer", gl.VertexAttribIPointer);
  Load(context, "glVertexAttribPointer", gl.VertexAttribPointer);
  Load(context, "glViewport", gl.Viewport);
  return gl;
}

}  // namespace pickbed::sim
