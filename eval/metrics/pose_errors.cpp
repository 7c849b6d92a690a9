#include "eval/metrics/pose_errors.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "scenes/geometry/sphere_directions.h"

namespace pickbed::eval {
namespace {

constexpr int kExtremeDirections = 512;

std::vector<Eigen::Vector3d> ReducedVertices(const std::vector<Eigen::Vector3d>& vertices,
                                             size_t wanted) {
  std::vector<bool> taken(vertices.size(), false);
  std::vector<Eigen::Vector3d> reduced;
  const auto take = [&](size_t i) {
    if (!taken[i]) reduced.push_back(vertices[i]);
    taken[i] = true;
  };
  for (const Eigen::Vector3d& direction : SphereDirections(kExtremeDirections)) {
    size_t best = 0;
    for (size_t i = 1; i < vertices.size(); ++i) {
      if (vertices[i].dot(direction) > vertices[best].dot(direction)) best = i;
    }
    take(best);
  }
  const size_t stride = std::max<size_t>(1, vertices.size() / wanted);
  for (size_t i = 0; i < vertices.size() && reduced.size() < wanted; i += stride) take(i);
  return reduced;
}

}  // namespace

MetricModel MakeMetricModel(const ObjectModel& model, int max_vertices) {
  MetricModel metric;
  const auto& vertices = model.mesh_O.vertices;
  const bool all = max_vertices <= 0 || vertices.size() <= static_cast<size_t>(max_vertices);
  metric.vertices_O = all ? vertices : ReducedVertices(vertices, max_vertices);
  if (!metric.vertices_O.empty()) metric.vertex_tree_O = VertexTree(metric.vertices_O);
  metric.symmetries_O = SymmetryTransforms(model.symmetries_O);
  metric.diameter_m = model.diameter_m;
  return metric;
}

Eigen::Vector3d MeanVertex(const MetricModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : model.vertices_O) sum += vertex;
  return sum / std::max<size_t>(1, model.vertices_O.size());
}

// Average Distance of model points (Hinterstoisser et al. 2012), for objects without symmetry.

double Add(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double sum = 0;
  for (const Eigen::Vector3d& v : model.vertices_O) sum += (X_est * v - X_true * v).norm();
  return sum / static_cast<double>(model.vertices_O.size());
}

// Average Distance to the closest model point (Hinterstoisser et al. 2012). For each vertex at the
// true pose it takes the nearest vertex at the estimated pose, like the BOP toolkit. The search is
// in the frame of the estimated object, where the vertices do not move.

double Adi(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  const Pose X_est_true = X_est.inverse() * X_true;
  std::vector<Eigen::Vector3d> moved_O;
  moved_O.reserve(model.vertices_O.size());
  for (const Eigen::Vector3d& v : model.vertices_O) moved_O.push_back(X_est_true * v);
  const VertexTree& known = model.vertex_tree_O;
  const std::vector<double> distances_m =
      known.empty() ? VertexTree(model.vertices_O).NearestDistances_m(moved_O)
                    : known.NearestDistances_m(moved_O);
  const double sum = std::accumulate(distances_m.begin(), distances_m.end(), 0.0);
  return sum / static_cast<double>(model.vertices_O.size());
}

// Maximum Symmetry-Aware Surface Distance: minimum over symmetries S of the largest
// X_est v - X_true S v| over the vertices v (Drost et al. 2017; BOP 2020, eq. 3).

double Mssd(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    // One matrix per vertex. No inverse, because published ground truth is not always orthonormal.
    const Pose X_sym = X_true * symmetry;
    const Eigen::Matrix3d M = X_est.linear() - X_sym.linear();
    const Eigen::Vector3d t = X_est.translation() - X_sym.translation();
    double worst = 0;
    for (const Eigen::Vector3d& v : model.vertices_O) {
      worst = std::max(worst, (M * v + t).squaredNorm());
      if (worst >= best) break;  // this symmetry cannot be the minimum
    }
    best = std::min(best, worst);
  }
  return std::sqrt(best);
}

// Maximum Symmetry-Aware Projection Distance: like MSSD, with distances between projections in
// pixels (BOP 2020, eq. 4).

double Mspd(const MetricModel& model, const CameraIntrinsics& camera, const Pose& X_est,
            const Pose& X_true) {
  std::vector<Eigen::Vector2d> estimated_px;
  estimated_px.reserve(model.vertices_O.size());
  for (const Eigen::Vector3d& v : model.vertices_O) {
    estimated_px.push_back(Project(camera, X_est * v));
  }
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Pose X = X_true * symmetry;
    double worst = 0;
    for (size_t i = 0; i < estimated_px.size() && worst < best; ++i) {
      const Eigen::Vector2d true_px = Project(camera, X * model.vertices_O[i]);
      worst = std::max(worst, (estimated_px[i] - true_px).squaredNorm());
    }
    best = std::min(best, worst);
  }
  return std::sqrt(best);
}

// Rotation and translation error, each the minimum over the symmetries. Without symmetries these
// are re and te of the BOP toolkit.

double RotationError(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Eigen::Matrix3d R_true = (X_true * symmetry).linear();
    // Formula of the BOP toolkit. It matters when published ground truth is not orthonormal.
    const double cosine = 0.5 * ((X_est.linear() * R_true.inverse()).trace() - 1);
    best = std::min(best, std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  return best;
}

double TranslationError(const MetricModel& model, const Pose& X_est, const Pose& X_true) {
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : model.symmetries_O) {
    const Eigen::Vector3d truth = X_true * symmetry.translation();
    best = std::min(best, (X_est.translation() - truth).norm());
  }
  return best;
}

}  // namespace pickbed::eval
