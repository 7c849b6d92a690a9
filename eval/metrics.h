#pragma once

// Pose errors between an estimate and the truth, as the BOP toolkit defines them (Hodan et al.
// 2018, 2020). Poses in the camera frame; metres, pixels, radians.

#include <span>
#include <string_view>
#include <vector>

#include "scenes/camera.h"
#include "scenes/object_model.h"

namespace pickbed {

// What a metric needs of a part, made once: vertices and expanded symmetries.
struct MetricModel {
  std::vector<Eigen::Vector3d> vertices_O;
  std::vector<Pose> symmetries_O;  // identity first
  double diameter_m = 0;
};

// At most `max_vertices` of the mesh (0 = all): those farthest out in many directions first, since
// a maximum over the surface is reached on the convex hull, then an even stride over the rest.
MetricModel MakeMetricModel(const ObjectModel& model, int max_vertices = 2000);

// Where the part is, in one point: no vertex moves less than the mean of all moves.
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
// Least over the symmetries.
double RotationError(const MetricModel& model, const Pose& X_est, const Pose& X_true);
double TranslationError(const MetricModel& model, const Pose& X_est, const Pose& X_true);

struct ToleranceModel;  // grasp/tolerance.h
inline constexpr char kPickRiskMetric[] = "pick_risk";
// Chance that a pick on the estimate fails, by the part's tolerance map; NaN without one.
double PickRisk(const ToleranceModel* tolerance, const Pose& X_est, const Pose& X_true);

struct MetricInput {
  const MetricModel& model;
  const CameraIntrinsics& camera;
  const Pose& X_est;
  const Pose& X_true;
  const ToleranceModel* tolerance = nullptr;  // of the part, where there is one
};
struct MetricRow {
  const char* name;
  const char* unit;
  const char* help;
  double (*compute)(const MetricInput& input);
  bool needs_camera = false;
};
// Adding a metric is one file in metrics/ and one row in metrics.cpp.
std::span<const MetricRow> MetricTable();

}  // namespace pickbed
