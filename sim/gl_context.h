#pragma once

// An OpenGL 3.3 core context without display, behind one interface with two makers: OSMesa and
// surfaceless EGL. Both libraries are opened at run time, so neither is needed to start the program
// and no libGL is linked; every GL entry point comes from GetProcAddress().

#include <memory>
#include <string>

namespace pickbed {

enum class GlBackend { kAuto, kOsMesa, kEgl };

struct GlContextOptions {
  GlBackend backend = GlBackend::kAuto;  // auto: OSMesa where present, else surfaceless EGL
  // llvmpipe's raster threads, 0 = none: one context a core without them is fastest. Read when the
  // process makes its first context of a backend; later contexts share that setting.
  int raster_threads = 0;
};

// Several contexts may live in one process, of both backends; a context may be used by one thread
// at a time.
class GlContext {
 public:
  using Function = void (*)();
  virtual ~GlContext() = default;
  // Cheap when this context is current in the calling thread already.
  virtual void MakeCurrent() = 0;
  virtual Function GetProcAddress(const char* name) = 0;
  virtual std::string Name() const = 0;  // "OSMesa" or "EGL", with GL_RENDERER
};

// The new context is current. Throws std::runtime_error that names the packages that are missing.
std::unique_ptr<GlContext> MakeGlContext(const GlContextOptions& options = {});

}  // namespace pickbed
