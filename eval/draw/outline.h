#pragma once

// Silhouette and crease lines of posed objects in an image, with hidden lines removed.

#include <Eigen/Core>
#include <map>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/bin/bin.h"
#include "scenes/camera/camera.h"
#include "scenes/camera/mesh_raster.h"
#include "scenes/geometry/mesh_edges.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

// Line segment in an image.
struct PixelLine {
  Eigen::Vector2d a, b;  // px
};

// Outlines of objects; the mesh edges of each object are cached.
class ObjectOutlines {
 public:
  explicit ObjectOutlines(const ObjectSet& objects) : objects_(objects) {}

  // Visible parts of the silhouette and crease edges of the object at X_CO, in px. Only the object
  // itself hides them. Returns nothing for an object that is not completely in front of the camera.
  std::vector<PixelLine> At(ObjectId object, const Pose& X_CO, const CameraIntrinsics& camera);

 private:
  // Edges and raster mesh of an object.
  struct Drawn {
    std::vector<MeshEdge> edges;
    RasterMesh mesh;
  };

  const ObjectSet& objects_;
  std::map<int, Drawn> drawn_;  // by object, computed on first use
};

// Returns one mesh of all boxes, in their frame.
TriangleMesh BoxesMesh(const std::vector<AxisAlignedBox>& boxes);

// Camera that looks at `target` from the direction `from` (any length) at `distance_m`. The up
// direction is z of the world, or y if it looks along z. Pixels are square; the principal point is
// in the image center.
Camera CameraTowards(const Eigen::Vector3d& target, const Eigen::Vector3d& from, double distance_m,
                     int width_px, int height_px, double focal_px);

// Camera that looks from the direction `from` and sees all points, as near as possible. `margin`:
// fraction of the image that stays free at each side, 0 .. 0.4. Throws std::logic_error without
// two different points.
Camera CameraAround(const std::vector<Eigen::Vector3d>& points_W, const Eigen::Vector3d& from,
                    double margin, int width_px, int height_px, double focal_px);

}  // namespace pickbed::eval
