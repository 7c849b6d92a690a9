#pragma once

// Visible regions and silhouettes of posed meshes, with hidden surfaces removed.

#include <array>
#include <map>
#include <span>
#include <vector>

#include "eval/draw/canvas.h"
#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/mesh_raster.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Finds for each pixel which of several posed meshes is the nearest. Meshes of objects are prepared
// once.
class RegionMap {
 public:
  // Regions of a picture of `camera`, in an image of `fineness` times its size.
  explicit RegionMap(const CameraIntrinsics& camera, int fineness = 2);

  // Adds a mesh. It gets the next id, from 1, and hides the meshes behind it. Where two meshes are
  // less than `tie_m` apart, the one that was added first is visible, so that almost equal poses do
  // not mix. A mesh that is not completely in front of the camera gets an id but no pixel.
  void Add(const RasterMesh& mesh, const Pose& X_CO, double tie_m = 0);

  // Returns whether a point of this depth (m, along camera z) at a pixel of the picture is in front
  // of all meshes, or behind them by less than a pixel beside the point.
  bool Sees(const Eigen::Vector2d& pixel, double depth_m) const;

  const Image<uint16_t>& ids() const { return ids_; }  // 0 = no mesh
  int fineness() const { return fineness_; }

 private:
  CameraIntrinsics camera_;  // of ids_
  int fineness_;
  FaceRaster raster_;
  Image<uint16_t> ids_;
  Image<float> depth_m_;
  uint16_t next_id_ = 1;
};

// Region of one id.
struct Silhouette {
  std::vector<Polyline> curves;  // closed, around the region and its holes; px of the picture
  Eigen::Vector2d inside{0, 0};  // the point that is farthest from the border; px of the picture
  double inside_px = 0;          // its distance to the border
};
// Returns the silhouettes of the ids 1 to `count`. `ids` has `fineness` times the size of the
// picture. Regions of a few pixels are left out.
std::vector<Silhouette> SilhouettesOf(const Image<uint16_t>& ids, int count, int fineness);
// An object at a pose.
struct PlacedObject {
  ObjectId object{0};
  Pose X_CO = Pose::Identity();
};
// Returns the visible silhouette of each object. If two are at almost the same pose, the first is
// visible.
std::vector<Silhouette> SilhouettesOf(const std::vector<PlacedObject>& placed,
                                      const ObjectSet& objects, const CameraIntrinsics& camera);
// Returns the silhouette of one id, with the curves around its holes or without.
enum class Holes { kWith, kWithout };
Silhouette SilhouetteOf(const Image<uint16_t>& ids, uint16_t id, int fineness,
                        Holes holes = Holes::kWith);

}  // namespace pickbed::eval
