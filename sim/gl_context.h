#pragma once

// An OpenGL 3.3 core context without display, behind one interface with two makers.

#include <memory>
#include <string>
#include <vector>

namespace pickbed {

enum class GlBackend { kAuto, kOsMesa, kEgl };

struct GlContextOptions {
  GlBackend backend = GlBackend::kAuto;  // auto: OSMesa where present, else surfaceless EGL
  int raster_threads = 0;                // llvmpipe's; 0 with one context a core is fastest
};

class GlContext {
 public:
  using Function = void (*)();
  virtual ~GlContext() = default;
  virtual void MakeCurrent() = 0;
  virtual Function GetProcAddress(const char* name) = 0;
  virtual std::string Name() const = 0;  // "OSMesa" or "EGL", with GL_RENDERER
};

// Throws std::runtime_error that names the packages that are missing.
std::unique_ptr<GlContext> MakeGlContext(const GlContextOptions& options = {});

}  // namespace pickbed
