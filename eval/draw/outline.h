#pragma once

// Silhouette and crease lines of posed objects in an image.

#include <Eigen/Core>
#include <map>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/ids.h"
#include "scenes/camera/camera.h"
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

  // Silhouette and crease edges of the object at X_CO that face the camera, in px. Edges
  // hidden by the object itself are included. Edges closer than 2 cm to the camera plane are
  // omitted.
  std::vector<PixelLine> At(ObjectId object, const Pose& X_CO, const CameraIntrinsics& camera);

 private:
  // Edge of a mesh with the normals of its two faces.
  struct Edge {
    Eigen::Vector3d a_O, b_O;
    Eigen::Vector3d normal_1_O, normal_2_O;
  };
  static std::vector<Edge> EdgesOf(const TriangleMesh& mesh);

  const ObjectSet& objects_;
  std::map<int, std::vector<Edge>> edges_;  // by object, computed on first use
};

// Camera that looks at `target` from the direction `from` (any length) at `distance_m`. The up
// direction is z of the world, or y if it looks along z. Pixels are square; the principal point is
// in the image center.
Camera CameraTowards(const Eigen::Vector3d& target, const Eigen::Vector3d& from, double distance_m,
                     int width_px, int height_px, double focal_px);

}  // namespace pickbed::eval
