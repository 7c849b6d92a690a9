#pragma once

// Headless rendering of color, depth and instance ids for any pinhole camera, in one pass. Normals
// and object coordinates are optional outputs of the same pass.
//
// Depth is in metres along the camera's z axis. Closed meshes show their front faces, open ones
// both sides. Near and far planes follow from the instances in view, and nothing nearer than 5 mm
// is drawn. Instances out of view cost nothing. Only the rectangle around the others is drawn and
// read.
//
// All calls throw InputError for an image without pixels or with a side above 16384 px. They throw
// std::out_of_range for an unknown mesh handle and std::runtime_error for OpenGL errors. A renderer
// owns its OpenGL context. Only one thread at a time may use it.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
#include "scenes/geometry/triangle_mesh.h"
#include "scenes/image/image.h"
#include "scenes/scene.h"
#include "sim/render/gl_context.h"

namespace pickbed::sim {

// A point light.
struct Light {
  Eigen::Vector3d position_W{0.3, -0.4, 1.5};  // m
  double ambient = 0.35;                       // 0..1
  double diffuse = 0.65;                       // 0..1
  bool shadow = false;                         // cast shadows with filtered edges, by a shadow map
  double shadow_softness_m = 0.002;  // half width of a shadow's edge, up to a few centimetres
};

// Appearance of a surface in addition to the colors of its mesh.
struct Material {
  Eigen::Vector3d tint = Eigen::Vector3d::Ones();  // factors of red, green and blue
  double gloss = 0;                                // 0..1, strength of a white highlight
  double grain = 0;                                // 0..1, depth of a random dark pattern
  double grain_cells_pm = 200;                     // cells of the pattern per metre
  friend bool operator==(const Material&, const Material&) = default;
};

// Limits of the level of detail (scenes/geometry/mesh_levels.h). A mesh is drawn at the coarsest
// level whose deviation from the original is at most the larger of the two. Zeros always draw the
// original.
struct DetailOptions {
  double deviation_m = 1e-4;
  double deviation_px = 0.25;  // at the instance's nearest point
};

// Drawing method of plain surfaces: no texture, vertex colors, gloss or grain, in images without
// shadows, normals or coordinates. The software rasterizer (sim/render/software_raster.h) is faster
// for them.
enum class PlainSurfaces { kOwnRaster, kOpenGl };

// One mesh to draw, with its pose and material.
struct RenderInstance {
  int mesh = 0;  // handle from AddMesh
  Pose X_WO = Pose::Identity();
  uint16_t id = 0;  // 0 = background
  Material material = {};
};

// Outputs of an image besides depth.
struct RenderOutputs {
  bool color = true;
  bool ids = true;
  bool normals = false;
  bool coordinates = false;
};

// Images that were not requested are empty. Pixels without a surface are zero in all images.
struct RenderedImage {
  Image<Rgb8> color;
  Image<float> depth_m;  // along camera z, 0 = no surface
  Image<uint16_t> ids;
  Image<Eigen::Vector3f> normals_C;      // unit vectors towards the camera
  Image<Eigen::Vector3f> coordinates_O;  // m, the visible point in its instance's object frame
};

// Renders instances of uploaded meshes.
class Renderer {
 public:
  explicit Renderer(const GlContextOptions& options = {}, const DetailOptions& detail = {},
                    PlainSurfaces plain_surfaces = PlainSurfaces::kOwnRaster);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  // Uploads the mesh and its coarser levels of detail. Returns its handle.
  int AddMesh(const TriangleMesh& mesh);

  // Renders all instances as seen by one camera.
  RenderedImage Render(const Camera& camera, std::span<const RenderInstance> instances,
                       const Light& light = {}, const RenderOutputs& outputs = {});
  // Renders the same scene for several cameras. A shadow map is made once for all of them.
  std::vector<RenderedImage> RenderCameras(std::span<const Camera> cameras,
                                           std::span<const RenderInstance> instances,
                                           const Light& light = {},
                                           const RenderOutputs& outputs = {});
  // Renders depth and ids only, which is faster.
  RenderedImage RenderDepth(const Camera& camera, std::span<const RenderInstance> instances);

  // Renders many small views without shadows in few draw and read calls. View i shows only
  // instances[i], seen by cameras[i]. Throws InputError if the two sizes differ.
  std::vector<RenderedImage> RenderEach(std::span<const Camera> cameras,
                                        std::span<const RenderInstance> instances,
                                        const Light& light = {});
  std::vector<RenderedImage> RenderEachDepth(std::span<const Camera> cameras,
                                             std::span<const RenderInstance> instances);

  // Same as RenderEach, but returns only the number of pixels that each instance covers in its
  // view, for any id.
  std::vector<int> CountEach(std::span<const Camera> cameras,
                             std::span<const RenderInstance> instances);

  // Returns the bounding box of a mesh in its own frame.
  const Bounds& MeshBoundsOf(int mesh) const;

  // Returns the OpenGL backend and renderer, see GlContext::Name().
  std::string ContextName() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Renders scenes of fixed objects. Meshes of the bin and of each object are uploaded once. The id
// of scene.objects[i] is its `instance` + 1; the bin's id is 0.
class SceneRenderer {
 public:
  SceneRenderer(const ObjectSet& objects, const Bin& bin, const GlContextOptions& options = {},
                const DetailOptions& detail = {});
  RenderedImage Render(const Scene& scene, const Camera& camera, const Light& light = {},
                       const RenderOutputs& outputs = {});
  std::vector<RenderedImage> RenderCameras(const Scene& scene, std::span<const Camera> cameras,
                                           const Light& light = {},
                                           const RenderOutputs& outputs = {});
  // Returns the instances of a scene, the bin (id 0) last. The caller may change materials and draw
  // them by renderer().
  std::vector<RenderInstance> InstancesOf(const Scene& scene);

  // Returns for each scene.objects[i] its pixels in `ids` over its unoccluded pixels. The latter
  // are counted on a canvas large enough for the whole instance, so pixels outside the image count
  // as occluded (BOP's visib_fract). The fraction is 0 if the instance covers no pixel.
  std::vector<double> VisibleFractions(const Scene& scene, const Camera& camera,
                                       const Image<uint16_t>& ids);
  Renderer& renderer() { return renderer_; }
  // Handle in renderer().
  int ObjectMesh(ObjectId object) const { return object_meshes_.at(object); }

 private:
  int BinMeshOf(const Bin& bin);

  Renderer renderer_;
  std::vector<std::pair<Bin, int>> bin_meshes_;  // all bins rendered so far, with their meshes
  std::vector<int> object_meshes_;
};

}  // namespace pickbed::sim
