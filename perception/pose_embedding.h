#pragma once

// Poses of one part as points of a plain space, so that pose distance becomes Euclidean distance
// and a whole batch of them one matrix product.
//
// The point of a pose is the position of eight key points of the part (corners of its bounding box;
// the ends of the axis for a continuous symmetry), divided by sqrt(8) diameters: the distance of
// two points is the root mean square displacement of the key points in diameters. Symmetric poses
// are several points, "twins"; the pose distance is the least over the twins of one side.

#include <Eigen/Core>
#include <vector>

#include "scenes/object_model.h"

namespace pickbed {

class PoseEmbedding {
 public:
  using Point = Eigen::Matrix<float, 24, 1>;
  using Points = Eigen::Matrix<float, 24, Eigen::Dynamic>;  // by column

  explicit PoseEmbedding(const ObjectModel& model);

  int variants() const { return static_cast<int>(symmetries_O_.size()); }
  Point Embed(const Pose& X_AO) const;
  // As many as variants(), by the part's symmetries; the first is Embed(X_AO). No allocation where
  // `points` has that size already.
  void EmbedVariants(const Pose& X_AO, Points& points) const;
  float Distance(const Pose& X_AO, const Pose& X_AO_other) const;
  // Two poses at distance d have this point of the part at most so many times d diameters apart: 1
  // in the middle of the key points, more outside. Of parts with a continuous symmetry: a point on
  // its axis.
  double Leverage(const Eigen::Vector3d& p_O) const;

 private:
  Eigen::Matrix<double, 3, 8> keypoints_O_;
  std::vector<Pose> symmetries_O_;
  double scale_ = 1;  // 1 / (sqrt(8) diameters)
};

}  // namespace pickbed
