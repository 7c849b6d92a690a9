#pragma once

// Silhouette and creases of posed parts as lines in an image.

#include <Eigen/Core>
#include <map>
#include <vector>

#include "scenes/camera.h"
#include "scenes/object_model.h"

namespace pickbed {

struct PixelLine {
  Eigen::Vector2d a, b;  // px
};

class PartOutlines {
 public:
  explicit PartOutlines(const ObjectSet& objects) : objects_(objects) {}

  // Edges of the part that face the camera; those hidden by the part itself, too. Nothing of what
  // is nearer than 2 cm.
  std::vector<PixelLine> At(int object, const Pose& X_CO, const CameraIntrinsics& camera);

 private:
  // An edge of a mesh with the normals of the faces on its two sides.
  struct Edge {
    Eigen::Vector3d a_O, b_O;
    Eigen::Vector3d normal_1_O, normal_2_O;
  };
  static std::vector<Edge> EdgesOf(const TriangleMesh& mesh);

  const ObjectSet& objects_;
  std::map<int, std::vector<Edge>> edges_;  // by object, made when first drawn
};

}  // namespace pickbed
