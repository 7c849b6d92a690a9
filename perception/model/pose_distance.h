#pragma once

// Distances between poses of one object, modulo its symmetries: an embedding in a Euclidean space,
// the maximum displacement of key points, and the rotation angle.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "perception/layer.h"
#include "scenes/geometry/symmetry.h"
#include "scenes/objects/object_model.h"

namespace pickbed::perception {

// Embeds poses in a Euclidean space, so that a batch of pose distances is one matrix product.
//
// A pose maps to the positions of eight key points of the object, divided by sqrt(8) diameters. The
// key points are the corners of the bounding box, or the ends of the axis for a continuous
// symmetry. The distance of two points is the root mean square displacement of the key points in
// diameters. Each discrete symmetry gives another point of the same pose. The pose distance is the
// minimum over these variants of one of the two poses.
class PoseEmbedding {
 public:
  using Point = Eigen::Matrix<float, 24, 1>;
  using Points = Eigen::Matrix<float, 24, Eigen::Dynamic>;  // one point per column

  // Throws InputError for an object whose vertices are all at one point.
  explicit PoseEmbedding(const ObjectModel& model);

  // Number of discrete symmetries, including the identity.
  int variants() const { return static_cast<int>(symmetries_O_.size()); }
  Point Embed(const Pose& X_AO) const;
  // Writes one point per symmetry; the first is Embed(X_AO). Does not allocate if `points` already
  // has variants() columns.
  void EmbedVariants(const Pose& X_AO, Points& points) const;
  // Returns the pose distance in diameters.
  float Distance(const Pose& X_AO, const Pose& X_AO_other) const;
  // Returns the factor L such that p_O moves at most L * d diameters between two poses at distance
  // d. It is 1 at the center of the key points and larger elsewhere. With a continuous symmetry,
  // p_O must be on its axis.
  double Leverage(const Eigen::Vector3d& p_O) const;

 private:
  Eigen::Matrix<double, 3, 8> keypoints_O_;
  std::vector<Pose> symmetries_O_;
  double scale_ = 1;  // 1 / (sqrt(8) diameters)
};

// Maximum displacement of the key points between two poses, in diameters, minimised over the
// discrete symmetries. The key points are the corners of the bounding box, or points on the axis
// for a continuous symmetry.
class PoseDistance {
 public:
  // Throws InputError for an object whose vertices are all at one point.
  explicit PoseDistance(const ObjectModel& model);
  double operator()(const Pose& X_CA, const Pose& X_CB) const;

  double diameter_m() const { return diameter_m_; }
  int keypoints() const { return static_cast<int>(keypoints_O_.size()); }
  // Returns keypoints() points per symmetry, identity first.
  const std::vector<Eigen::Vector3d>& symmetric_keypoints_O() const { return variants_O_; }

 private:
  std::vector<Eigen::Vector3d> keypoints_O_;
  std::vector<Eigen::Vector3d> variants_O_;
  double diameter_m_ = 0;
};

// Angle between two orientations of an object, the minimum over its symmetries. It is the error
// measure of methods that look up whole views.
class RotationDistance {
 public:
  explicit RotationDistance(const SymmetrySet& symmetries_O);

  // Returns an angle in [0, pi]. With one continuous symmetry it is the angle between the axes; for
  // a ball it is 0.
  double operator()(const Eigen::Matrix3d& R_CO, const Eigen::Matrix3d& R_CO_other) const;

 private:
  bool ball_ = false;
  std::optional<Eigen::Vector3d> axis_O_;
  std::vector<Eigen::Matrix3d> discrete_O_;  // identity first
};

}  // namespace pickbed::perception
