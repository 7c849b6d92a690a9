#include "sim/render/renderer.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/camera/footprint.h"
#include "scenes/geometry/mesh_levels.h"
#include "sim/render/atlas.h"
#include "sim/render/gl_drawer.h"
#include "sim/render/gl_readback.h"
#include "sim/render/gl_targets.h"
#include "sim/render/shadow_map.h"
#include "sim/render/software_raster.h"

namespace pickbed::sim {
namespace {

constexpr int kMaxImageSide = 16384;  // OpenGL's limit in Mesa
constexpr int kAtlasSide = 512;       // px; larger pages do not fit into the cache
constexpr int kTargetStep = 64;  // px; framebuffer sides are multiples, so that few are created

// Images are allocated and freed by the megabyte. By default glibc returns this memory to the
// system at once, and fresh pages cost more than drawing. These settings make glibc keep it. The
// top pad is for thread heaps (64 MiB each): glibc returns an empty one unless less than the pad
// would remain.
void KeepFreedPages() {
  mallopt(M_MMAP_THRESHOLD, 64 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, 64 << 20);
}

void CheckImageSize(int width, int height) {
  CheckInput(width > 0 && height > 0 && width <= kMaxImageSide && height <= kMaxImageSide,
             fmt::format("image size {} x {}: width and height must be 1 to {}", width, height,
                         kMaxImageSide));
}

int RoundUp(int side) { return (side + kTargetStep - 1) / kTargetStep * kTargetStep; }

std::array<float, 3> ToFloats(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

DrawSetup SetupFor(GlOutputs outputs, std::span<const RenderInstance> instances,
                   const Light& light) {
  DrawSetup setup;
  if (outputs & OutputBit(kIdOutput)) setup.switches |= kIdsSwitch;
  if (outputs & OutputBit(kNormalOutput)) setup.switches |= kNormalsSwitch;
  if (outputs & OutputBit(kCoordinateOutput)) setup.switches |= kCoordinatesSwitch;
  if (outputs & OutputBit(kColorOutput)) {
    setup.switches |= kColorSwitch;
    const bool plain = std::all_of(instances.begin(), instances.end(), [](const auto& instance) {
      return instance.material == Material();
    });
    if (!plain) setup.switches |= kMaterialSwitch;
  }
  setup.ambient = static_cast<float>(light.ambient);
  setup.diffuse = static_cast<float>(light.diffuse);
  return setup;
}

// An instance in the view of a camera.
struct Seen {
  const RenderInstance* instance;
  Pose X_CO;
  Footprint footprint;
  int level;
};

}  // namespace

struct Renderer::Impl {
  Impl(const GlContextOptions& options, const DetailOptions& detail_options, PlainSurfaces surfaces)
      : detail(detail_options),
        plain_surfaces(surfaces),
        context(MakeGlContext(options)),
        gl(LoadGlFunctions(*context)),
        drawer(gl) {
    KeepFreedPages();
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  }

  ~Impl() {
    context->MakeCurrent();
    drawer.DeleteAll();
    targets.DeleteAll(gl);
    shadow_map.Delete(gl);
  }

  // Returns the level of detail of a mesh whose nearest point is at depth `near_m`.
  int LevelOf(const GlMesh& mesh, double near_m, const CameraIntrinsics& k) const {
    const double pixel_m = std::max(near_m, kNearestDrawn_m) / std::max(k.fx(), k.fy());
    const double allowed_m = std::max(detail.deviation_m, detail.deviation_px * pixel_m);
    int level = 0;
    while (level + 1 < static_cast<int>(mesh.levels.size()) &&
           mesh.levels[level + 1].deviation_m <= allowed_m) {
      ++level;
    }
    return level;
  }

  void CheckErrors() {
    if (const GLenum error = gl.GetError(); error != GL_NO_ERROR) {
      throw std::runtime_error(fmt::format("OpenGL error 0x{:04x} while drawing", error));
    }
  }

  std::vector<RenderedImage> DrawImages(std::span<const Camera> cameras,
                                        std::span<const RenderInstance> instances,
                                        const Light& light, const RenderOutputs& outputs) {
    context->MakeCurrent();
    GlOutputs wanted = OutputBit(kDepthOutput);
    if (outputs.color) wanted |= OutputBit(kColorOutput);
    if (outputs.ids) wanted |= OutputBit(kIdOutput);
    if (outputs.normals) wanted |= OutputBit(kNormalOutput);
    if (outputs.coordinates) wanted |= OutputBit(kCoordinateOutput);
    const DrawSetup setup = SetupFor(wanted, instances, light);
    const bool shadow =
        outputs.color && light.shadow && shadow_map.Draw(gl, drawer, instances, light);
    const bool plain = ArePlain(instances, wanted, light);
    std::vector<RenderedImage> out;
    out.reserve(cameras.size());
    for (const Camera& camera : cameras) {
      DrawSetup setup_here = setup;
      if (shadow) shadow_map.AddTo(setup_here, camera.X_CW());
      out.push_back(DrawImage(camera, instances, light, wanted, setup_here, plain));
    }
    CheckErrors();
    return out;
  }

  // Collects the instances in view. Returns whether all of them are entirely in front of the
  // camera.
  bool FindSeen(const Camera& camera, std::span<const RenderInstance> instances, DrawnBox& drawn,
                std::vector<Seen>& seen) const {
    const CameraIntrinsics& k = camera.intrinsics;
    CheckImageSize(k.width(), k.height());
    const Pose X_CW = camera.X_CW();
    bool in_front = true;
    for (const RenderInstance& instance : instances) {
      const GlMesh& mesh = drawer.Mesh(instance.mesh);
      const Pose X_CO = X_CW * instance.X_WO;
      const Footprint footprint = FootprintOf(mesh.bounds_O, X_CO, k);
      if (!footprint.Overlaps(k)) continue;
      drawn.Include(footprint);
      seen.push_back({&instance, X_CO, footprint, LevelOf(mesh, footprint.near_m, k)});
      in_front = in_front && footprint.in_front;
    }
    return in_front;
  }

  RenderedImage DrawImage(const Camera& camera, std::span<const RenderInstance> instances,
                          const Light& light, GlOutputs outputs, const DrawSetup& setup,
                          bool plain) {
    const CameraIntrinsics& k = camera.intrinsics;
    DrawnBox drawn(k);
    std::vector<Seen> seen;
    const bool in_front = FindSeen(camera, instances, drawn, seen);
    if (seen.empty()) return Readback::EmptyImage(outputs, k.width(), k.height());
    const Eigen::Vector3d light_C = camera.X_CW() * light.position_W;
    if (!plain || !in_front) return DrawByGl(k, seen, drawn.box(), light_C, outputs, setup);
    RenderedImage image = Readback::EmptyImage(outputs, k.width(), k.height());
    DrawPlain(k, seen, drawn.box());
    plain_drawer.raster().Write(light, light_C, image);
    return image;
  }

  // Begins the image and draws the instances. The caller ends the image.
  void DrawPlain(const CameraIntrinsics& k, const std::vector<Seen>& seen, const ImageBox& box) {
    plain_drawer.raster().Begin(k, box);
    for (const Seen& s : seen) plain_drawer.Draw(*s.instance, s.level, s.X_CO);
  }

  RenderedImage DrawByGl(const CameraIntrinsics& k, const std::vector<Seen>& seen,
                         const ImageBox& box, const Eigen::Vector3d& light_C, GlOutputs outputs,
                         DrawSetup setup) {
    DepthRange range;
    for (const Seen& s : seen) range.Include(s.footprint);
    std::vector<Draw> draws;
    draws.reserve(seen.size());
    for (const Seen& s : seen) {
      draws.push_back({s.instance->mesh, s.level, s.footprint.near_m,
                       AttributesOf(s.X_CO, *s.instance, k, range, Eigen::Vector2i::Zero(),
                                    k.width(), k.height()),
                       ToFloats(light_C)});
    }
    SortNearFirst(draws);
    // If a single instance is in view, its id is set at each pixel with a depth and is not drawn.
    const bool one_id = outputs & OutputBit(kIdOutput) && draws.size() == 1;
    if (one_id) {
      outputs &= ~OutputBit(kIdOutput);
      setup.switches &= ~kIdsSwitch;
    }
    const bool extras = outputs & (OutputBit(kNormalOutput) | OutputBit(kCoordinateOutput));
    BeginTarget(gl,
                targets.Of(gl, extras ? GlTargetKind::kImageAndExtras : GlTargetKind::kImage,
                           std::min(k.width(), RoundUp(box.width)),
                           std::min(k.height(), RoundUp(box.height))),
                outputs);
    // The viewport is the whole image, shifted by whole pixels. So the result does not depend on
    // the box.
    gl.Viewport(-box.x, -box.y, k.width(), k.height());
    drawer.DrawAll(draws, setup);
    RenderedImage image = readback.ReadImage(gl, outputs, k.width(), k.height(), box);
    if (one_id) Readback::FillIds(image, box, seen[0].instance->id);
    return image;
  }

  // Returns whether the software rasterizer can draw these instances if they are in front of the
  // camera.
  bool ArePlain(std::span<const RenderInstance> instances, GlOutputs outputs,
                const Light& light) const {
    const bool color = outputs & OutputBit(kColorOutput);
    if (plain_surfaces == PlainSurfaces::kOpenGl || (color && light.shadow)) return false;
    if (outputs & (OutputBit(kNormalOutput) | OutputBit(kCoordinateOutput))) return false;
    return std::all_of(instances.begin(), instances.end(), [&](const RenderInstance& instance) {
      return plain_drawer.CanDraw(instance, color);
    });
  }

  // Draws the views of a page and leaves the page's target bound.
  const GlTarget& DrawPage(const AtlasLayout& layout, const AtlasPage& page,
                           std::span<const Camera> cameras,
                           std::span<const RenderInstance> instances, const Light& light,
                           GlTargetKind kind, GlOutputs outputs, const DrawSetup& setup) {
    const GlTarget& target = targets.Of(gl, kind, RoundUp(page.width), RoundUp(page.height));
    std::vector<Draw> draws;
    draws.reserve(page.tile_count);
    for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
      const CameraIntrinsics& k = cameras[i].intrinsics;
      const GlMesh& mesh = drawer.Mesh(instances[i].mesh);
      const Pose X_CW = cameras[i].X_CW();
      const Pose X_CO = X_CW * instances[i].X_WO;
      const Footprint footprint = FootprintOf(mesh.bounds_O, X_CO, k);
      if (!footprint.Overlaps(k)) continue;
      DepthRange range;
      range.Include(footprint);
      const AtlasTile& tile = layout.tiles[i];
      Draw draw{
          instances[i].mesh, LevelOf(mesh, footprint.near_m, k), footprint.near_m,
          AttributesOf(X_CO, instances[i], k, range, {tile.x, tile.y}, target.width, target.height),
          ToFloats(X_CW * light.position_W)};
      if (!footprint.IsInside(k)) draw.scissor = {tile.x, tile.y, k.width(), k.height()};
      draws.push_back(draw);
    }
    std::stable_sort(draws.begin(), draws.end(), [](const Draw& a, const Draw& b) {
      return std::tuple(a.scissor.has_value(), a.mesh, a.level) <
             std::tuple(b.scissor.has_value(), b.mesh, b.level);
    });
    BeginTarget(gl, target, outputs);
    gl.Viewport(0, 0, target.width, target.height);
    drawer.DrawAll(draws, setup);
    return target;
  }

  static void CheckSameNumber(std::span<const Camera> cameras,
                              std::span<const RenderInstance> instances) {
    CheckInput(
        cameras.size() == instances.size(),
        fmt::format("{} cameras for {} instances: each view needs one camera and one instance",
                    cameras.size(), instances.size()));
  }

  static AtlasLayout LayOut(std::span<const Camera> cameras) {
    std::vector<TileSize> sizes;
    sizes.reserve(cameras.size());
    for (const Camera& camera : cameras) {
      const CameraIntrinsics& k = camera.intrinsics;
      CheckImageSize(k.width(), k.height());
      sizes.push_back({k.width(), k.height()});
    }
    return LayOutAtlas(sizes, kAtlasSide);
  }

  static ImageBox BoxOf(const AtlasTile& tile, const CameraIntrinsics& k) {
    return {tile.x, tile.y, k.width(), k.height()};
  }

  // Ids are not drawn. Each pixel with a depth belongs to the view's only instance.
  std::vector<RenderedImage> DrawEach(std::span<const Camera> cameras,
                                      std::span<const RenderInstance> instances, const Light& light,
                                      bool color) {
    CheckSameNumber(cameras, instances);
    context->MakeCurrent();
    const GlOutputs outputs = OutputBit(kDepthOutput) | (color ? OutputBit(kColorOutput) : 0u);
    const DrawSetup setup = SetupFor(outputs, instances, light);
    std::vector<RenderedImage> out(cameras.size());
    if (ArePlain(instances, outputs, {})) {
      for (size_t i = 0; i < cameras.size(); ++i) {
        out[i] = DrawImage(cameras[i], {&instances[i], 1}, light, outputs | OutputBit(kIdOutput),
                           setup, true);
      }
      return out;
    }
    const AtlasLayout layout = LayOut(cameras);
    for (const AtlasPage& page : layout.pages) {
      const GlTarget& target =
          DrawPage(layout, page, cameras, instances, light, GlTargetKind::kImage, outputs, setup);
      readback.ReadPage(gl, target, outputs);
      for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
        out[i] = readback.CropPage(BoxOf(layout.tiles[i], cameras[i].intrinsics), instances[i].id);
      }
    }
    CheckErrors();
    return out;
  }

  std::vector<int> CountEach(std::span<const Camera> cameras,
                             std::span<const RenderInstance> instances) {
    CheckSameNumber(cameras, instances);
    std::vector<int> counts;
    counts.reserve(cameras.size());
    for (size_t i = 0; i < cameras.size(); ++i) {
      DrawnBox drawn(cameras[i].intrinsics);
      std::vector<Seen> seen;
      const bool in_front = FindSeen(cameras[i], {&instances[i], 1}, drawn, seen);
      if (plain_surfaces == PlainSurfaces::kOpenGl || !in_front) {
        return CountEachByGl(cameras, instances);
      }
      if (!seen.empty()) DrawPlain(cameras[i].intrinsics, seen, drawn.box());
      counts.push_back(seen.empty() ? 0 : plain_drawer.raster().CountCovered());
    }
    return counts;
  }

  // The covered area depends on neither depth nor drawing order.
  std::vector<int> CountEachByGl(std::span<const Camera> cameras,
                                 std::span<const RenderInstance> instances) {
    context->MakeCurrent();
    const AtlasLayout layout = LayOut(cameras);
    DrawSetup setup;
    setup.switches = kCoverageSwitch;
    std::vector<int> counts(cameras.size(), 0);
    for (const AtlasPage& page : layout.pages) {
      readback.ReadCoverage(gl, DrawPage(layout, page, cameras, instances, {},
                                         GlTargetKind::kCoverage, OutputBit(kDepthOutput), setup));
      for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
        counts[i] = readback.CountCovered(BoxOf(layout.tiles[i], cameras[i].intrinsics));
      }
    }
    CheckErrors();
    return counts;
  }

  DetailOptions detail;
  PlainSurfaces plain_surfaces;
  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  GlDrawer drawer;
  GlTargets targets;
  ShadowMap shadow_map;
  PlainDrawer plain_drawer;
  Readback readback;
};

Renderer::Renderer(const GlContextOptions& options, const DetailOptions& detail,
                   PlainSurfaces plain_surfaces)
    : impl_(std::make_unique<Impl>(options, detail, plain_surfaces)) {}
Renderer::~Renderer() = default;

int Renderer::AddMesh(const TriangleMesh& mesh) {
  impl_->context->MakeCurrent();
  const std::vector<MeshLevel> levels = MakeMeshLevels(mesh);
  const int handle = impl_->drawer.AddMesh(mesh, levels);
  impl_->plain_drawer.AddMesh(levels, impl_->drawer.Mesh(handle));
  return handle;
}

RenderedImage Renderer::Render(const Camera& camera, std::span<const RenderInstance> instances,
                               const Light& light, const RenderOutputs& outputs) {
  return std::move(impl_->DrawImages({&camera, 1}, instances, light, outputs)[0]);
}

std::vector<RenderedImage> Renderer::RenderCameras(std::span<const Camera> cameras,
                                                   std::span<const RenderInstance> instances,
                                                   const Light& light,
                                                   const RenderOutputs& outputs) {
  return impl_->DrawImages(cameras, instances, light, outputs);
}

RenderedImage Renderer::RenderDepth(const Camera& camera,
                                    std::span<const RenderInstance> instances) {
  RenderOutputs outputs;
  outputs.color = false;
  return Render(camera, instances, {}, outputs);
}

std::vector<RenderedImage> Renderer::RenderEach(std::span<const Camera> cameras,
                                                std::span<const RenderInstance> instances,
                                                const Light& light) {
  return impl_->DrawEach(cameras, instances, light, true);
}

std::vector<RenderedImage> Renderer::RenderEachDepth(std::span<const Camera> cameras,
                                                     std::span<const RenderInstance> instances) {
  return impl_->DrawEach(cameras, instances, {}, false);
}

std::vector<int> Renderer::CountEach(std::span<const Camera> cameras,
                                     std::span<const RenderInstance> instances) {
  return impl_->CountEach(cameras, instances);
}

const Bounds& Renderer::MeshBoundsOf(int mesh) const { return impl_->drawer.Mesh(mesh).bounds_O; }

std::string Renderer::ContextName() const { return impl_->context->Name(); }

}  // namespace pickbed::sim
