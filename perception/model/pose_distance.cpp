#include "perception/model/pose_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/geometry/decompositions.h"

namespace pickbed::perception {
namespace {

// Returns two points on the axis, as far from its center as the farthest corner of the box. They
// move like the rim when the object tilts, and do not move when it rotates about the axis. With two
// different axes, only their common point remains.
std::vector<Eigen::Vector3d> AxisKeypoints(const SymmetrySet& symmetries, const Bounds& box) {
  const Eigen::Vector3d a = symmetries.continuous_O.front().axis_O;
  const Eigen::Vector3d o = symmetries.continuous_O.front().offset_O;
  if (const ContinuousSymmetry* second = SecondAxis(symmetries)) return {second->offset_O};
  const Eigen::Vector3d center = o + a * a.dot(box.center() - o);
  const double reach = (box.Corners().colwise() - center).colwise().norm().maxCoeff();
  return {center - reach * a, center + reach * a};
}

// Both ends of the object along the axis, four times each.
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

// Returns the unit of the pose distances.
double DiameterOf(const ObjectModel& model) {
  const double diameter_m = model.diameter_m > 0 ? model.diameter_m : Diameter(model.mesh_O);
  CheckInput(diameter_m > 0,
             "object '" + model.name + "' has no extent; give it a mesh of several points");
  return diameter_m;
}

}  // namespace

PoseEmbedding::PoseEmbedding(const ObjectModel& model)
    : scale_(1.0 / (std::sqrt(8.0) * DiameterOf(model))) {
  const SymmetrySet& symmetries = model.symmetries_O;
  if (SecondAxis(symmetries)) {
    // Rotations about two axes generate all rotations about their common point.
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

// Displacements are B p for homogeneous p. Let H be the mean of p p^T over the key points. Their
// mean square displacement is tr(B H B^T), and |B p|^2 <= tr(B H B^T) p^T H^+ p for all p in the
// range of H (Cauchy-Schwarz).
double PoseEmbedding::Leverage(const Eigen::Vector3d& p_O) const {
  const Eigen::Matrix<double, 4, 8> points = keypoints_O_.colwise().homogeneous();
  const Eigen::Matrix4d moments = points * points.transpose() / 8;
  const Eigen::Vector4d p = p_O.homogeneous();
  return std::sqrt(p.dot(MinimumNormSolution(moments, p)));
}

RotationDistance::RotationDistance(const SymmetrySet& symmetries_O)
    : ball_(!symmetries_O.continuous_O.empty() && SecondAxis(symmetries_O) != nullptr),
      discrete_O_{Eigen::Matrix3d::Identity()} {
  if (!symmetries_O.continuous_O.empty()) axis_O_ = symmetries_O.continuous_O.front().axis_O;
  for (const Pose& symmetry : symmetries_O.discrete_O) discrete_O_.push_back(symmetry.linear());
}

double RotationDistance::operator()(const Eigen::Matrix3d& R_CO,
                                    const Eigen::Matrix3d& R_CO_other) const {
  if (ball_) return 0;
  const Eigen::Matrix3d between = R_CO.transpose() * R_CO_other;
  if (axis_O_) {
    double largest_cos = -1;
    for (const Eigen::Matrix3d& S : discrete_O_) {
      largest_cos = std::max(largest_cos, axis_O_->dot(between * (S * *axis_O_)));
    }
    return std::acos(std::min(1.0, largest_cos));
  }
  double largest_trace = -1;
  for (const Eigen::Matrix3d& S : discrete_O_) {
    largest_trace = std::max(largest_trace, between.cwiseProduct(S.transpose()).sum());
  }
  return std::acos(std::clamp(0.5 * (largest_trace - 1), -1.0, 1.0));
}

PoseDistance::PoseDistance(const ObjectModel& model) {
  const Bounds box = MeshBounds(model.mesh_O);
  if (model.symmetries_O.continuous_O.empty()) {
    const Eigen::Matrix<double, 3, 8> corners = box.Corners();
    for (const auto& corner : corners.colwise()) keypoints_O_.push_back(corner);
  } else {
    keypoints_O_ = AxisKeypoints(model.symmetries_O, box);
  }
  variants_O_ = keypoints_O_;
  for (const Pose& S : model.symmetries_O.discrete_O) {
    for (const Eigen::Vector3d& p : keypoints_O_) variants_O_.push_back(S * p);
  }
  diameter_m_ = DiameterOf(model);
}

double PoseDistance::operator()(const Pose& X_CA, const Pose& X_CB) const {
  const Pose X_AB = X_CA.inverse(Eigen::Isometry) * X_CB;
  const size_t n = keypoints_O_.size();
  double smallest = std::numeric_limits<double>::max();
  for (size_t begin = 0; begin < variants_O_.size(); begin += n) {
    double largest = 0;
    for (size_t i = 0; i < n && largest < smallest; ++i) {
      largest = std::max(largest, (X_AB * variants_O_[begin + i] - keypoints_O_[i]).squaredNorm());
    }
    smallest = std::min(smallest, largest);
  }
  return std::sqrt(smallest) / diameter_m_;
}

}  // namespace pickbed::perception
