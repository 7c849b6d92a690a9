#include "sim/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "scenes/check.h"
#include "sim/atlas.h"
#include "sim/footprint.h"
#include "sim/gl_objects.h"
#include "sim/gl_readback.h"

namespace pickbed {
namespace {

constexpr int kMaxImageSide = 16384;  // OpenGL's limit in Mesa
constexpr int kAtlasSide = 512;       // px; larger pages fall out of the cache
constexpr size_t kMaxTargets = 6;     // framebuffers that are kept, of different sizes

struct DepthRange {
  double near_m = std::numeric_limits<double>::infinity();
  double far_m = 0;

  void Include(const Footprint& footprint) {
    near_m = std::min(near_m, std::max(kNearestDrawn_m, 0.999 * footprint.near_m));
    far_m = std::max(far_m, 1.001 * footprint.far_m);
  }
};

// Clip coordinates of OpenGL for a view at a tile of a page. Pixel centres are whole numbers
// here and halves in OpenGL: u + 0.5 = (clip x / clip w + 1) / 2 * width.
InstanceAttributes AttributesOf(const Pose& X_CO, uint32_t id, const CameraIntrinsics& k,
                                const DepthRange& range, const Eigen::Vector3d& light_C,
                                const AtlasTile& tile, const AtlasPage& page) {
  InstanceAttributes out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out.X_CO_rows[4 * row + column] = static_cast<float>(X_CO(row, column));
    }
  }
  out.xy_projection = {static_cast<float>(2 * k.fx / page.width),
                       static_cast<float>(2 * (k.cx + tile.x + 0.5) / page.width - 1),
                       static_cast<float>(2 * k.fy / page.height),
                       static_cast<float>(2 * (k.cy + tile.y + 0.5) / page.height - 1)};
  const double depth = range.far_m - range.near_m;
  out.z_projection = {static_cast<float>((range.far_m + range.near_m) / depth),
                      static_cast<float>(-2 * range.far_m * range.near_m / depth)};
  out.light_C = {static_cast<float>(light_C.x()), static_cast<float>(light_C.y()),
                 static_cast<float>(light_C.z())};
  out.id = id;
  return out;
}

}  // namespace

struct Renderer::Impl {
  // One instance to draw.
  struct Draw {
    int mesh = 0;
    int level = 0;
    double near_m = 0;
    InstanceAttributes attributes;
    std::optional<std::array<int, 4>> scissor = std::nullopt;  // x, y, width, height in px
  };
  enum class Parts { kDepthAndIds, kAll };

  Impl(const GlContextOptions& options, const DetailOptions& detail_options)
      : detail(detail_options), context(MakeGlContext(options)), gl(LoadGlFunctions(*context)) {
    gl.GenBuffers(1, &instance_buffer);
    gl.Enable(GL_DEPTH_TEST);
    gl.FrontFace(GL_CW);  // we draw upside down, see sim/shaders.h
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  }

  ~Impl() {
    context->MakeCurrent();
    for (GlMesh& mesh : meshes) DeleteMesh(gl, mesh);
    for (GlTarget& target : targets) DeleteTarget(gl, target);
    for (auto& [key, program] : programs) gl.DeleteProgram(program.program);
    gl.DeleteBuffers(1, &instance_buffer);
  }

  const GlMesh& MeshOf(const RenderInstance& instance) const { return meshes.at(instance.mesh); }

  // Level of detail for a mesh whose nearest point is at `near_m`.
  int LevelOf(const GlMesh& mesh, double near_m, const CameraIntrinsics& k) const {
    const double pixel_m = std::max(near_m, kNearestDrawn_m) / std::max(k.fx, k.fy);
    const double allowed_m = std::max(detail.deviation_m, detail.deviation_px * pixel_m);
    int level = 0;
    while (level + 1 < static_cast<int>(mesh.levels.size()) &&
           mesh.levels[level + 1].deviation_m <= allowed_m) {
      ++level;
    }
    return level;
  }

  // Kept by size, the least recently used one goes.
  const GlTarget& TargetOf(int width, int height) {
    CheckInput(width > 0 && height > 0 && width <= kMaxImageSide && height <= kMaxImageSide,
               fmt::format("image size {} x {}: width and height must be 1 to {}", width, height,
                           kMaxImageSide));
    const auto found = std::find_if(targets.begin(), targets.end(), [&](const GlTarget& t) {
      return t.width == width && t.height == height;
    });
    if (found != targets.end()) {
      std::rotate(found, found + 1, targets.end());
    } else {
      if (targets.size() == kMaxTargets) {
        DeleteTarget(gl, targets.front());
        targets.erase(targets.begin());
      }
      targets.push_back(MakeTarget(gl, width, height));
    }
    return targets.back();
  }

  void UseProgramFor(const GlMesh& mesh, Parts parts, const Light& light) {
    const bool color = parts == Parts::kAll;
    const bool texture = color && mesh.texture != 0;
    const bool flat = color && mesh.flat;
    const int key = color | texture << 1 | flat << 2;
    auto found = programs.find(key);
    if (found == programs.end()) {
      found = programs.emplace(key, MakeProgram(gl, color, texture, flat)).first;
    }
    gl.UseProgram(found->second.program);
    if (texture) gl.BindTexture(GL_TEXTURE_2D, mesh.texture);
    if (color) {
      gl.Uniform2f(found->second.ambient_diffuse, static_cast<float>(light.ambient),
                   static_cast<float>(light.diffuse));
    }
  }

  void UploadInstances(const std::vector<Draw>& draws) {
    std::vector<InstanceAttributes> attributes(draws.size());
    for (size_t i = 0; i < draws.size(); ++i) attributes[i] = draws[i].attributes;
    gl.BindBuffer(GL_ARRAY_BUFFER, instance_buffer);
    gl.BufferData(GL_ARRAY_BUFFER, attributes.size() * sizeof(InstanceAttributes),
                  attributes.data(), GL_STREAM_DRAW);
  }

  // draws[begin, end) share mesh and level.
  void DrawInstances(const std::vector<Draw>& draws, size_t begin, size_t end) {
    const GlMesh& mesh = meshes[draws[begin].mesh];
    const GlMeshLevel& level = mesh.levels[draws[begin].level];
    if (mesh.cull_back) {
      gl.Enable(GL_CULL_FACE);
    } else {
      gl.Disable(GL_CULL_FACE);
    }
    gl.BindVertexArray(level.vertex_array);
    BindInstances(gl, instance_buffer, begin);
    gl.DrawElementsInstanced(GL_TRIANGLES, level.index_count, GL_UNSIGNED_INT, nullptr,
                             static_cast<GLsizei>(end - begin));
  }

  // Each run of one mesh and level by one call; a draw with a scissor box is a run of its own.
  void DrawAll(const std::vector<Draw>& draws, Parts parts, const Light& light) {
    UploadInstances(draws);
    for (size_t begin = 0, end = 0; begin < draws.size(); begin = end) {
      const Draw& first = draws[begin];
      end = begin + 1;
      while (!first.scissor && end < draws.size() && !draws[end].scissor &&
             draws[end].mesh == first.mesh && draws[end].level == first.level) {
        ++end;
      }
      if (first.scissor) {
        gl.Enable(GL_SCISSOR_TEST);
        const auto& [x, y, width, height] = *first.scissor;
        gl.Scissor(x, y, width, height);
      } else {
        gl.Disable(GL_SCISSOR_TEST);
      }
      UseProgramFor(meshes[first.mesh], parts, light);
      DrawInstances(draws, begin, end);
    }
  }

  // Groups of one mesh and level, the nearer groups first so that the bin hides nothing's work.
  static void SortForDrawing(std::vector<Draw>& draws) {
    std::map<std::pair<int, int>, std::pair<double, int>> sums;
    for (const Draw& draw : draws) {
      auto& [sum, count] = sums[{draw.mesh, draw.level}];
      sum += draw.near_m;
      ++count;
    }
    const auto mean = [&](const Draw& draw) {
      const auto& [sum, count] = sums.at({draw.mesh, draw.level});
      return sum / count;
    };
    std::stable_sort(draws.begin(), draws.end(), [&](const Draw& a, const Draw& b) {
      const double mean_a = mean(a), mean_b = mean(b);
      if (mean_a != mean_b) return mean_a < mean_b;
      return std::tie(a.mesh, a.level, a.near_m) < std::tie(b.mesh, b.level, b.near_m);
    });
  }

  void CheckErrors() {
    if (const GLenum error = gl.GetError(); error != GL_NO_ERROR) {
      throw std::runtime_error(fmt::format("OpenGL error 0x{:04x} while drawing", error));
    }
  }

  RenderedImage DrawImage(const Camera& camera, std::span<const RenderInstance> instances,
                          const Light& light, Parts parts) {
    context->MakeCurrent();
    const CameraIntrinsics& k = camera.intrinsics;
    const GlTarget& target = TargetOf(k.width, k.height);
    const Pose X_CW = camera.X_WC.inverse();
    const Eigen::Vector3d light_C = X_CW * light.position_W;
    DepthRange range;
    std::vector<std::pair<const RenderInstance*, Footprint>> visible;
    for (const RenderInstance& instance : instances) {
      const Footprint footprint = FootprintOf(MeshOf(instance).bounds_O, X_CW * instance.X_WO, k);
      if (!footprint.Overlaps(k)) continue;
      range.Include(footprint);
      visible.emplace_back(&instance, footprint);
    }
    std::vector<Draw> draws;
    draws.reserve(visible.size());
    for (const auto& [instance, footprint] : visible) {
      draws.push_back({instance->mesh, LevelOf(MeshOf(*instance), footprint.near_m, k),
                       footprint.near_m,
                       AttributesOf(X_CW * instance->X_WO, instance->id, k, range, light_C, {},
                                    {target.width, target.height})});
    }
    SortForDrawing(draws);
    BeginTarget(gl, target, parts == Parts::kAll);
    DrawAll(draws, parts, light);
    readback.ReadAll(gl, target, parts == Parts::kAll);
    CheckErrors();
    return readback.Crop({}, k.width, k.height);
  }

  // Draws the views of a page and leaves the page's target bound.
  const GlTarget& DrawPage(const AtlasLayout& layout, const AtlasPage& page,
                           std::span<const Camera> cameras,
                           std::span<const RenderInstance> instances, const Light& light,
                           Parts parts) {
    const GlTarget& target = TargetOf(page.width, page.height);
    std::vector<Draw> draws;
    draws.reserve(page.tile_count);
    for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
      const CameraIntrinsics& k = cameras[i].intrinsics;
      const GlMesh& mesh = MeshOf(instances[i]);
      const Pose X_CW = cameras[i].X_WC.inverse();
      const Pose X_CO = X_CW * instances[i].X_WO;
      const Footprint footprint = FootprintOf(mesh.bounds_O, X_CO, k);
      if (!footprint.Overlaps(k)) continue;
      DepthRange range;
      range.Include(footprint);
      const AtlasTile& tile = layout.tiles[i];
      Draw draw{instances[i].mesh, LevelOf(mesh, footprint.near_m, k), footprint.near_m,
                AttributesOf(X_CO, instances[i].id, k, range, X_CW * light.position_W, tile, page)};
      if (!footprint.IsInside(k)) draw.scissor = {tile.x, tile.y, k.width, k.height};
      draws.push_back(draw);
    }
    std::stable_sort(draws.begin(), draws.end(), [](const Draw& a, const Draw& b) {
      return std::tuple(a.scissor.has_value(), a.mesh, a.level) <
             std::tuple(b.scissor.has_value(), b.mesh, b.level);
    });
    BeginTarget(gl, target, parts == Parts::kAll);
    DrawAll(draws, parts, light);
    return target;
  }

  static AtlasLayout LayOut(std::span<const Camera> cameras,
                            std::span<const RenderInstance> instances) {
    CheckInput(cameras.size() == instances.size(),
               fmt::format("{} cameras for {} instances: each view needs one of both",
                           cameras.size(), instances.size()));
    std::vector<TileSize> sizes;
    sizes.reserve(cameras.size());
    for (const Camera& camera : cameras) {
      sizes.push_back({camera.intrinsics.width, camera.intrinsics.height});
    }
    return LayOutAtlas(sizes, kAtlasSide);
  }

  std::vector<RenderedImage> DrawEach(std::span<const Camera> cameras,
                                      std::span<const RenderInstance> instances, const Light& light,
                                      Parts parts) {
    context->MakeCurrent();
    const AtlasLayout layout = LayOut(cameras, instances);
    std::vector<RenderedImage> out(cameras.size());
    for (const AtlasPage& page : layout.pages) {
      const GlTarget& target = DrawPage(layout, page, cameras, instances, light, parts);
      readback.ReadAll(gl, target, parts == Parts::kAll);
      for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
        const CameraIntrinsics& k = cameras[i].intrinsics;
        out[i] = readback.Crop(layout.tiles[i], k.width, k.height);
      }
    }
    CheckErrors();
    return out;
  }

  // Depth tells what is covered, since an id may be 0.
  std::vector<int> CountEach(std::span<const Camera> cameras,
                             std::span<const RenderInstance> instances) {
    context->MakeCurrent();
    const AtlasLayout layout = LayOut(cameras, instances);
    std::vector<int> counts(cameras.size(), 0);
    for (const AtlasPage& page : layout.pages) {
      readback.ReadDepth(gl, DrawPage(layout, page, cameras, instances, {}, Parts::kDepthAndIds));
      for (int i = page.first_tile; i < page.first_tile + page.tile_count; ++i) {
        const CameraIntrinsics& k = cameras[i].intrinsics;
        counts[i] = readback.CountCovered(layout.tiles[i], k.width, k.height);
      }
    }
    CheckErrors();
    return counts;
  }

  DetailOptions detail;
  std::unique_ptr<GlContext> context;
  GlFunctions gl;
  GLuint instance_buffer = 0;
  std::vector<GlMesh> meshes;
  std::vector<GlTarget> targets;
  std::map<int, GlProgram> programs;  // by switches of sim/shaders.h
  Readback readback;
};

Renderer::Renderer(const GlContextOptions& options, const DetailOptions& detail)
    : impl_(std::make_unique<Impl>(options, detail)) {}
Renderer::~Renderer() = default;

int Renderer::AddMesh(const TriangleMesh& mesh) {
  impl_->context->MakeCurrent();
  impl_->meshes.push_back(UploadMesh(impl_->gl, mesh, impl_->instance_buffer));
  return static_cast<int>(impl_->meshes.size()) - 1;
}

RenderedImage Renderer::Render(const Camera& camera, std::span<const RenderInstance> instances,
                               const Light& light) {
  return impl_->DrawImage(camera, instances, light, Impl::Parts::kAll);
}

RenderedImage Renderer::RenderDepth(const Camera& camera,
                                    std::span<const RenderInstance> instances) {
  return impl_->DrawImage(camera, instances, {}, Impl::Parts::kDepthAndIds);
}

std::vector<RenderedImage> Renderer::RenderEach(std::span<const Camera> cameras,
                                                std::span<const RenderInstance> instances,
                                                const Light& light) {
  return impl_->DrawEach(cameras, instances, light, Impl::Parts::kAll);
}

std::vector<RenderedImage> Renderer::RenderEachDepth(std::span<const Camera> cameras,
                                                     std::span<const RenderInstance> instances) {
  return impl_->DrawEach(cameras, instances, {}, Impl::Parts::kDepthAndIds);
}

std::vector<int> Renderer::CountEach(std::span<const Camera> cameras,
                                     std::span<const RenderInstance> instances) {
  return impl_->CountEach(cameras, instances);
}

const Bounds& Renderer::MeshBoundsOf(int mesh) const { return impl_->meshes.at(mesh).bounds_O; }

std::string Renderer::ContextName() const { return impl_->context->Name(); }

}  // namespace pickbed
