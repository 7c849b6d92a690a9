#pragma once

// Pose errors between an estimate and the ground truth, as defined by the BOP toolkit (Hodan et al.
// 2018, 2020). Poses are in the camera frame. Units are m, px and rad.

#include <vector>

#include "eval/layer.h"
#include "eval/metrics/vertex_tree.h"
#include "scenes/camera/camera.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {
struct ToleranceModel;
}

namespace pickbed::eval {

// Precomputed data of an object for the metrics.
struct MetricModel {
  // Vertices of the mesh, possibly reduced.
  std::vector<Eigen::Vector3d> vertices_O;
  VertexTree vertex_tree_O;        // of the same vertices, for ADI; empty = made when needed
  std::vector<Pose> symmetries_O;  // all symmetry transforms, identity first
  double diameter_m = 0;
};

// Precomputes the metric data with at most `max_vertices` of the mesh (0 = all). Vertices that are
// extreme in many directions come first, because the maximum over the surface is on the convex
// hull. The rest is sampled with a uniform stride.
MetricModel MakeMetricModel(const ObjectModel& model, int max_vertices = 2000);

// Mean of the vertices. Its displacement between two poses is a lower bound of the largest vertex
// displacement.
Eigen::Vector3d MeanVertex(const MetricModel& model);

// Maximum symmetry-aware surface distance, m.
double Mssd(const MetricModel& model, const Pose& X_est, const Pose& X_true);
// Maximum symmetry-aware projection distance, px.
double Mspd(const MetricModel& model, const CameraIntrinsics& camera, const Pose& X_est,
            const Pose& X_true);
// Mean distance of equal model points, without symmetries, m (Hinterstoisser et al. 2012).
double Add(const MetricModel& model, const Pose& X_est, const Pose& X_true);
// Mean distance to the closest model point, m.
double Adi(const MetricModel& model, const Pose& X_est, const Pose& X_true);
// Minimum rotation error over the symmetries, rad.
double RotationError(const MetricModel& model, const Pose& X_est, const Pose& X_true);
// Minimum translation error over the symmetries, m.
double TranslationError(const MetricModel& model, const Pose& X_est, const Pose& X_true);

inline constexpr char kPickRiskMetric[] = "pick_risk";
// Probability that a pick on the estimated pose fails, from the tolerance model; NaN without one.
double PickRisk(const ToleranceModel* tolerance, const Pose& X_est, const Pose& X_true);

}  // namespace pickbed::eval
