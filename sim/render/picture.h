#pragma once

// Pictures of scenes for people: a table under the bin, plausible materials, soft shadows, ambient
// occlusion and smooth edges. Sensors and training use SceneRenderer, which is faster. The ids are
// the same as in SceneRenderer.

#include <Eigen/Core>
#include <map>
#include <span>
#include <vector>

#include "scenes/camera/camera.h"
#include "scenes/image/image.h"
#include "scenes/scene.h"
#include "sim/render/picture_shading.h"
#include "sim/render/renderer.h"

namespace pickbed::sim {

// Size of a picture and effort for it.
struct PictureOptions {
  int scale = 2;    // picture pixels per camera pixel and axis, 1..8
  int samples = 2;  // samples per picture pixel and axis, 1..4
  int threads = 1;  // from 1; the picture does not depend on it
  // Throws std::logic_error if a value is out of range.
  void Validate() const;
};

// A further instance in a picture, such as a hand.
struct PictureInstance {
  RenderInstance instance;  // its id must exceed the ids of the scene
  PictureMaterial material;
};

// A finished picture with the ids of the surfaces in it (instance + 1; 0 = bin, table, background).
struct Picture {
  Image<Rgb8> color;
  Image<uint16_t> ids;
  Camera camera;  // of the picture's pixels
};

// Draws pictures of scenes of fixed objects. Keeps references to `renderer` and `objects`.
class PictureRenderer {
 public:
  PictureRenderer(SceneRenderer& renderer, const ObjectSet& objects);

  // Draws the scene and `more` as seen by `camera`, in a picture of `scale` times its size. Of
  // instances with the same id, the last one gives the material. Throws InputError if a side of the
  // picture has no pixels, or if its length times `samples` exceeds 16384 px. Throws
  // std::logic_error if an option is out of range.
  Picture Render(const Scene& scene, const Camera& camera, const PictureOptions& options = {},
                 std::span<const PictureInstance> more = {});

 private:
  int TableMesh(double side_m);

  SceneRenderer& renderer_;
  const ObjectSet& objects_;
  std::map<double, int> tables_;  // mesh handles by side length
};

}  // namespace pickbed::sim
