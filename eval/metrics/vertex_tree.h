#pragma once

// Exact search for the nearest of many points, with FLANN's single kd-tree.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

// Kd-tree of points. Copies share it.
class VertexTree {
 public:
  VertexTree() = default;
  // Takes at least one point, m.
  explicit VertexTree(const std::vector<Eigen::Vector3d>& points);

  bool empty() const { return impl_ == nullptr; }
  // Returns the distance from each query to its nearest point, m. The tree must not be empty.
  std::vector<double> NearestDistances_m(const std::vector<Eigen::Vector3d>& queries) const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace pickbed::eval
