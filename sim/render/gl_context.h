#pragma once

// Headless OpenGL 3.3 core context with two backends: OSMesa and surfaceless EGL. Both libraries
// are opened at run time. So the program starts without them and does not link libGL. All GL
// functions come from GetProcAddress().

#include <memory>
#include <string>

#include "sim/layer.h"

namespace pickbed::sim {

enum class GlBackend { kAuto, kOsMesa, kEgl };

// Options of MakeGlContext().
struct GlContextOptions {
  GlBackend backend = GlBackend::kAuto;  // kAuto: OSMesa if present, else surfaceless EGL
  // Rasterizer threads of llvmpipe; 0 = none. One context per core without threads is fastest. The
  // value is read when the process makes its first context of a backend; later contexts share it.
  int raster_threads = 0;
};

// A process may have several contexts, also of both backends. Only one thread at a time may use a
// context.
class GlContext {
 public:
  using Function = void (*)();
  virtual ~GlContext() = default;
  // Fast if this context is already current in the calling thread.
  virtual void MakeCurrent() = 0;
  virtual Function GetProcAddress(const char* name) = 0;
  virtual std::string Name() const = 0;  // "OSMesa" or "EGL", with GL_RENDERER
};

// Creates a context and makes it current. Throws std::runtime_error with the names of the missing
// packages.
std::unique_ptr<GlContext> MakeGlContext(const GlContextOptions& options = {});

}  // namespace pickbed::sim
