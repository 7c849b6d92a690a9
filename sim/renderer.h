#pragma once

// Draws colour, depth and instance ids of any pinhole camera in one pass, without display; on
// request normals and object coordinates in the same pass.
//
// Depth is metric along the camera's z axis. Closed meshes show their front faces, open ones both
// sides. Near and far planes follow from what is in view; nothing nearer than 5 mm is drawn.
// Instances out of view cost nothing, and only the rectangle that holds the rest is drawn and read.
//
// All calls throw InputError for an image without pixels or larger than 16384, std::out_of_range
// for an unknown mesh handle, std::runtime_error when OpenGL fails. A renderer has an OpenGL
// context of its own and may be used by one thread at a time.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scenes/camera.h"
#include "scenes/image.h"
#include "scenes/scene.h"
#include "scenes/triangle_mesh.h"
#include "sim/gl_context.h"

namespace pickbed {

struct Light {
  Eigen::Vector3d position_W{0.3, -0.4, 1.5};  // m, a point light
  double ambient = 0.35;                       // 0..1
  double diffuse = 0.65;                       // 0..1
  bool shadow = false;                         // cast by a shadow map with a filtered edge
  double shadow_softness_m = 0.002;            // half width of a shadow's edge, at most some cm
};

// How a surface looks, on top of the colours of its mesh.
struct Material {
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();  // factor of red, green and blue
  double gloss = 0;                                // 0..1, strength of a white highlight
  double grain = 0;                                // 0..1, depth of a random dark pattern
  double grain_cells_pm = 200;                     // its cells a metre
  friend bool operator==(const Material&, const Material&) = default;
};

// A mesh is drawn by the coarsest of its levels of detail (sim/mesh_levels.h) that deviates from
// the original by no more than the larger of the two; zeros draw the original always.
struct DetailOptions {
  double deviation_m = 1e-4;
  double deviation_px = 0.25;  // at the instance's nearest point
};

// Pictures without shadows, normals or coordinates, of surfaces without texture, colours of
// vertices, gloss or grain, are drawn by a rasteriser of our own, which is faster
// (sim/cpu_raster.h).
enum class PlainSurfaces { kOwnRaster, kOpenGl };

struct RenderInstance {
  int mesh = 0;  // from AddMesh
  Pose X_WO = Pose::Identity();
  uint16_t id = 0;  // 0 = background
  Material material = {};
};

// What a picture holds besides depth.
struct RenderOutputs {
  bool color = true;
  bool ids = true;
  bool normals = false;
  bool coordinates = false;
};

// Images that were not asked for are empty. Where nothing is seen, all are zero.
struct RenderedImage {
  Image<Rgb8> color;
  Image<float> depth_m;  // along camera z, 0 = nothing
  Image<uint16_t> ids;
  Image<Eigen::Vector3f> normals_C;      // unit vectors that face the camera
  Image<Eigen::Vector3f> coordinates_O;  // m, the point that is seen, in its instance's own frame
};

class Renderer {
 public:
  explicit Renderer(const GlContextOptions& options = {}, const DetailOptions& detail = {},
                    PlainSurfaces plain_surfaces = PlainSurfaces::kOwnRaster);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  // Uploads the mesh (with coarser levels of detail) and returns its handle.
  int AddMesh(const TriangleMesh& mesh);

  RenderedImage Render(const Camera& camera, std::span<const RenderInstance> instances,
                       const Light& light = {}, const RenderOutputs& outputs = {});
  // The same scene as several cameras see it; a shadow map is made once for all of them.
  std::vector<RenderedImage> RenderCameras(std::span<const Camera> cameras,
                                           std::span<const RenderInstance> instances,
                                           const Light& light = {},
                                           const RenderOutputs& outputs = {});
  // Depth and ids only: cheaper, for views that need no colour.
  RenderedImage RenderDepth(const Camera& camera, std::span<const RenderInstance> instances);

  // Many small views without shadows of single instances in few draw and read-back calls: view i is
  // instances[i] alone as cameras[i] sees it. Throws InputError when the two differ in number.
  std::vector<RenderedImage> RenderEach(std::span<const Camera> cameras,
                                        std::span<const RenderInstance> instances,
                                        const Light& light = {});
  std::vector<RenderedImage> RenderEachDepth(std::span<const Camera> cameras,
                                             std::span<const RenderInstance> instances);

  // As RenderEach, but only the number of pixels that each instance covers in its view (whatever
  // its id). `result[i]` belongs to cameras[i].
  std::vector<int> CountEach(std::span<const Camera> cameras,
                             std::span<const RenderInstance> instances);

  // Bounding box of an added mesh in its own frame.
  const Bounds& MeshBoundsOf(int mesh) const;

  std::string ContextName() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A scene with its meshes uploaded once: the bin's and each object's. The id of scene.objects[i] in
// the pictures is its `instance` + 1; the bin's is 0.
class SceneRenderer {
 public:
  SceneRenderer(const ObjectSet& objects, const Bin& bin, const GlContextOptions& options = {},
                const DetailOptions& detail = {});
  RenderedImage Render(const Scene& scene, const Camera& camera, const Light& light = {},
                       const RenderOutputs& outputs = {});
  std::vector<RenderedImage> RenderCameras(const Scene& scene, std::span<const Camera> cameras,
                                           const Light& light = {},
                                           const RenderOutputs& outputs = {});
  // The bin (id 0) last. Materials may be changed before they are drawn by renderer().
  std::vector<RenderInstance> InstancesOf(const Scene& scene);

  // Of each scene.objects[i]: its pixels in `ids` over its pixels alone on a canvas large enough to
  // hold all of it, so pixels outside the image count as hidden (BOP's visib_fract). 0 where it
  // covers no pixel at all.
  std::vector<double> VisibleFractions(const Scene& scene, const Camera& camera,
                                       const Image<uint16_t>& ids);
  Renderer& renderer() { return renderer_; }
  int ObjectMesh(int object) const { return object_meshes_.at(object); }  // handle in renderer()

 private:
  int BinMeshOf(const Bin& bin);

  Renderer renderer_;
  std::vector<std::pair<Bin, int>> bin_meshes_;  // bins that were seen, with their meshes
  std::vector<int> object_meshes_;
};

}  // namespace pickbed
