#include "sim/render/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <stdexcept>
#include <utility>

namespace pickbed::sim {
namespace {

constexpr const char* kOsMesaPackages = "libosmesa6";
constexpr const char* kEglPackages = "libegl1 libegl-mesa0 libgl1-mesa-dri";

// When a thread switches contexts, the library that made the old one current must release it.
// OSMesa and EGL share Mesa's dispatch table but do not know each other. Contexts are identified by
// serial numbers, because pointers may be reused.
struct CurrentContext {
  uint64_t serial = 0;
  void (*release)() = nullptr;
};
thread_local CurrentContext current;
std::atomic<uint64_t> last_serial{0};

void ReleaseCurrent() {
  if (current.release) current.release();
  current = {};
}

// A shared library. It stays open until the process ends, because threads and exit handlers of the
// driver may run until then.
class Library {
 public:
  Library(const char* file, const char* packages) : handle_(dlopen(file, RTLD_NOW | RTLD_LOCAL)) {
    if (!handle_) {
      const char* reason = dlerror();
      throw std::runtime_error(fmt::format("cannot open {} ({}); install the packages: {}", file,
                                           reason ? reason : "no reason given", packages));
    }
    file_ = file;
    packages_ = packages;
  }

  template <typename F>
  F* Load(const char* name) const {
    void* symbol = dlsym(handle_, name);
    if (!symbol) {
      throw std::runtime_error(
          fmt::format("{} has no {}; reinstall the packages: {}", file_, name, packages_));
    }
    return reinterpret_cast<F*>(symbol);
  }

 private:
  void* handle_;
  const char* file_ = "";
  const char* packages_ = "";
};

std::string RendererString(GlContext& context) {
  constexpr unsigned kGlRenderer = 0x1F01;
  using GetString = const unsigned char* (*)(unsigned);
  const auto get_string = reinterpret_cast<GetString>(context.GetProcAddress("glGetString"));
  const unsigned char* text = get_string ? get_string(kGlRenderer) : nullptr;
  return text ? reinterpret_cast<const char*>(text) : "unknown renderer";
}

struct OsMesaApi {
  Library library{"libOSMesa.so.8", kOsMesaPackages};
  decltype(&OSMesaCreateContextAttribs) create =
      library.Load<decltype(OSMesaCreateContextAttribs)>("OSMesaCreateContextAttribs");
  decltype(&OSMesaMakeCurrent) make_current =
      library.Load<decltype(OSMesaMakeCurrent)>("OSMesaMakeCurrent");
  decltype(&OSMesaDestroyContext) destroy =
      library.Load<decltype(OSMesaDestroyContext)>("OSMesaDestroyContext");
  decltype(&OSMesaGetProcAddress) get_proc_address =
      library.Load<decltype(OSMesaGetProcAddress)>("OSMesaGetProcAddress");
};

const OsMesaApi& OsMesa() {
  static const OsMesaApi api;
  return api;
}

class OsMesaGlContext : public GlContext {
 public:
  OsMesaGlContext() : api_(OsMesa()), serial_(++last_serial) {
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              3,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              3,
                              0};
    context_ = api_.create(attributes, nullptr);
    if (!context_) {
      throw std::runtime_error(
          fmt::format("OSMesa makes no OpenGL 3.3 core context; Mesa 12 to 25.0 does: install {}",
                      kOsMesaPackages));
    }
    MakeCurrent();
    name_ = "OSMesa, " + RendererString(*this);
  }

  ~OsMesaGlContext() override {
    if (current.serial == serial_) ReleaseCurrent();
    api_.destroy(context_);
  }

  void MakeCurrent() override {
    if (current.serial == serial_) return;
    ReleaseCurrent();
    // OSMesa requires this buffer, but the renderer draws into its own framebuffers.
    if (!api_.make_current(context_, buffer_.data(), GL_UNSIGNED_BYTE, kBufferSide, kBufferSide)) {
      throw std::runtime_error("OSMesaMakeCurrent failed");
    }
    current = {serial_, [] { OsMesa().make_current(nullptr, nullptr, 0, 0, 0); }};
  }

  Function GetProcAddress(const char* name) override { return api_.get_proc_address(name); }
  std::string Name() const override { return name_; }

 private:
  static constexpr int kBufferSide = 8;
  const OsMesaApi& api_;
  uint64_t serial_;
  OSMesaContext context_ = nullptr;
  std::array<uint8_t, 4 * kBufferSide * kBufferSide> buffer_{};
  std::string name_;
};

struct EglApi {
  Library library{"libEGL.so.1", kEglPackages};
  decltype(&eglGetProcAddress) get_proc_address =
      library.Load<decltype(eglGetProcAddress)>("eglGetProcAddress");
  decltype(&eglMakeCurrent) make_current = library.Load<decltype(eglMakeCurrent)>("eglMakeCurrent");
  decltype(&eglCreateContext) create_context =
      library.Load<decltype(eglCreateContext)>("eglCreateContext");
  decltype(&eglDestroyContext) destroy_context =
      library.Load<decltype(eglDestroyContext)>("eglDestroyContext");
  decltype(&eglBindAPI) bind_api = library.Load<decltype(eglBindAPI)>("eglBindAPI");
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLConfig config = nullptr;

  // The process has one display. It is not reference counted, so it is never terminated.
  EglApi() {
    const auto get_display = library.Load<decltype(eglGetPlatformDisplay)>("eglGetPlatformDisplay");
    const auto initialize = library.Load<decltype(eglInitialize)>("eglInitialize");
    const auto choose = library.Load<decltype(eglChooseConfig)>("eglChooseConfig");
    display = get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    EGLint count = 0;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                             EGL_NONE};
    if (display == EGL_NO_DISPLAY || !initialize(display, nullptr, nullptr) ||
        !bind_api(EGL_OPENGL_API) || !choose(display, wanted, &config, 1, &count) || count < 1) {
      throw std::runtime_error(fmt::format(
          "EGL has no surfaceless display with OpenGL; install the packages: {}", kEglPackages));
    }
  }
};

const EglApi& Egl() {
  static const EglApi api;
  return api;
}

class EglGlContext : public GlContext {
 public:
  EglGlContext() : api_(Egl()), serial_(++last_serial) {
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 3,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    api_.bind_api(EGL_OPENGL_API);  // a setting of the calling thread
    context_ = api_.create_context(api_.display, api_.config, EGL_NO_CONTEXT, attributes);
    if (context_ == EGL_NO_CONTEXT) {
      throw std::runtime_error(fmt::format(
          "EGL makes no OpenGL 3.3 core context; install the packages: {}", kEglPackages));
    }
    MakeCurrent();
    name_ = "EGL, " + RendererString(*this);
  }

  ~EglGlContext() override {
    if (current.serial == serial_) ReleaseCurrent();
    api_.destroy_context(api_.display, context_);
  }

  void MakeCurrent() override {
    if (current.serial == serial_) return;
    ReleaseCurrent();
    api_.bind_api(EGL_OPENGL_API);
    if (!api_.make_current(api_.display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
      throw std::runtime_error("eglMakeCurrent without a surface failed");
    }
    current = {serial_, [] {
                 Egl().make_current(Egl().display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
               }};
  }

  Function GetProcAddress(const char* name) override { return api_.get_proc_address(name); }
  std::string Name() const override { return name_; }

 private:
  const EglApi& api_;
  uint64_t serial_;
  EGLContext context_ = EGL_NO_CONTEXT;
  std::string name_;
};

}  // namespace

std::unique_ptr<GlContext> MakeGlContext(const GlContextOptions& options) {
  setenv("LP_NUM_THREADS", std::to_string(options.raster_threads).c_str(), 1);
  if (options.backend == GlBackend::kEgl) return std::make_unique<EglGlContext>();
  if (options.backend == GlBackend::kOsMesa) return std::make_unique<OsMesaGlContext>();
  try {
    return std::make_unique<OsMesaGlContext>();
  } catch (const std::runtime_error& osmesa_error) {
    try {
      return std::make_unique<EglGlContext>();
    } catch (const std::runtime_error& egl_error) {
      throw std::runtime_error(fmt::format("cannot draw without a display: {}; {}",
                                           osmesa_error.what(), egl_error.what()));
    }
  }
}

}  // namespace pickbed::sim
