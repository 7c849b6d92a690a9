#pragma once

// Closest point and ray queries on a mesh, by a tree of bounding boxes.

#include <memory>
#include <optional>
#include <vector>

#include "scenes/triangle_mesh.h"

namespace pickbed {

struct SurfaceHit {
  Eigen::Vector3d point;
  Eigen::Vector3d normal;  // of the triangle, unit
  int triangle = -1;
  double distance = 0;  // m
};

class MeshQuery {
 public:
  // Copies what it needs; faces without area are left out. Throws InputError when none is left.
  explicit MeshQuery(const TriangleMesh& mesh);
  ~MeshQuery();
  MeshQuery(MeshQuery&&) noexcept;

  SurfaceHit ClosestPoint(const Eigen::Vector3d& p) const;
  // Whether ClosestPoint(p).distance <= distance_m, found out sooner.
  bool IsWithin(const Eigen::Vector3d& p, double distance_m) const;
  // First hit along origin + t * direction (unit), min_t < t < max_t.
  std::optional<SurfaceHit> Raycast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double min_t, double max_t) const;
  // Every crossing of the line and the surface, by rising t = distance (may be negative). A line
  // through the side that two faces share gives one hit.
  std::vector<SurfaceHit> AllHits(const Eigen::Vector3d& origin,
                                  const Eigen::Vector3d& direction) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
