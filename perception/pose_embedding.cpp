#include "perception/pose_embedding.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

namespace pickbed {
namespace {

// Both ends of the part along the axis, four times each.
Eigen::Matrix<double, 3, 8> AxisEnds(const TriangleMesh& mesh, const ContinuousSymmetry& axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    const double t = (vertex - axis.offset_O).dot(axis.axis_O);
    low = std::min(low, t);
    high = std::max(high, t);
  }
  Eigen::Matrix<double, 3, 8> ends;
  for (int i = 0; i < 8; ++i) ends.col(i) = axis.offset_O + (i & 1 ? high : low) * axis.axis_O;
  return ends;
}

}  // namespace

PoseEmbedding::PoseEmbedding(const ObjectModel& model)
    : scale_(1.0 / (std::sqrt(8.0) * model.diameter_m)) {
  const SymmetrySet& symmetries = model.symmetries_O;
  if (SecondAxis(symmetries)) {
    // Turning about two axes is turning about their common point.
    keypoints_O_ = model.mass.com_O.replicate<1, 8>();
  } else if (!symmetries.continuous_O.empty()) {
    keypoints_O_ = AxisEnds(model.mesh_O, symmetries.continuous_O.front());
  } else {
    keypoints_O_ = MeshBounds(model.mesh_O).Corners();
  }
  symmetries_O_ = {Pose::Identity()};
  symmetries_O_.insert(symmetries_O_.end(), symmetries.discrete_O.begin(),
                       symmetries.discrete_O.end());
}

PoseEmbedding::Point PoseEmbedding::Embed(const Pose& X_AO) const {
  const Eigen::Matrix<float, 3, 8> moved = (scale_ * (X_AO * keypoints_O_)).cast<float>();
  return Eigen::Map<const Point>(moved.data());
}

void PoseEmbedding::EmbedVariants(const Pose& X_AO, Points& points) const {
  points.resize(Eigen::NoChange, variants());
  for (int i = 0; i < variants(); ++i) points.col(i) = Embed(X_AO * symmetries_O_[i]);
}

float PoseEmbedding::Distance(const Pose& X_AO, const Pose& X_AO_other) const {
  Points points;
  EmbedVariants(X_AO, points);
  return std::sqrt((points.colwise() - Embed(X_AO_other)).colwise().squaredNorm().minCoeff());
}

// Displacements are B p for homogeneous p. With H the mean of p p^T over the key points, their mean
// square is tr(B H B^T), and |B p|^2 <= tr(B H B^T) p^T H^+ p for all p in the range of H
// (Cauchy-Schwarz).
double PoseEmbedding::Leverage(const Eigen::Vector3d& p_O) const {
  const Eigen::Matrix<double, 4, 8> points = keypoints_O_.colwise().homogeneous();
  const Eigen::Matrix4d moments = points * points.transpose() / 8;
  const Eigen::Vector4d p = p_O.homogeneous();
  return std::sqrt(p.dot(moments.completeOrthogonalDecomposition().solve(p)));
}

}  // namespace pickbed
