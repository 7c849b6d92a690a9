#pragma once

// Closest-point and ray queries on a mesh. They use a tree of bounding boxes.

#include <memory>
#include <optional>
#include <vector>

#include "scenes/geometry/triangle_mesh.h"

namespace pickbed::scenes {

// A point of the surface that a query found, in the mesh's frame.
struct SurfaceHit {
  Eigen::Vector3d point;   // m
  Eigen::Vector3d normal;  // of the triangle, unit
  int triangle = -1;       // index in the mesh
  double distance = 0;     // m; for a ray or line the parameter t, which may be negative
};

// Search tree over the faces of one mesh. Points and directions are in the mesh's frame, in m.
class MeshQuery {
 public:
  // Copies the data that it needs and skips faces without area. Throws InputError when no face is
  // left.
  explicit MeshQuery(const TriangleMesh& mesh);
  ~MeshQuery();
  MeshQuery(MeshQuery&&) noexcept;

  // Returns the point of the surface that is nearest to `p`. Throws InputError if `p` is not finite
  // or so far away that the square of the distance is infinite.
  SurfaceHit ClosestPoint(const Eigen::Vector3d& p) const;
  // Returns whether ClosestPoint(p).distance <= distance_m, in less time.
  bool IsWithin(const Eigen::Vector3d& p, double distance_m) const;
  // Returns the first hit along origin + t * direction (unit) with min_t < t < max_t, in m.
  std::optional<SurfaceHit> Raycast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double min_t, double max_t) const;
  // Returns all crossings of the line and the surface, ordered by t = distance (may be negative). A
  // line through a side that two faces share gives one hit.
  std::vector<SurfaceHit> AllHits(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::scenes
