#include "eval/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace pickbed {
namespace {

constexpr int kExtremeDirections = 512;

// Directions spread evenly over the sphere (Fibonacci lattice).
Eigen::Vector3d SphereDirection(int i, int count) {
  const double z = 1 - (2 * i + 1.0) / count;
  const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

std::vector<Eigen::Vector3d> ReducedVertices(const std::vector<Eigen::Vector3d>& vertices,
                                             size_t wanted) {
  std::vector<bool> taken(vertices.size(), false);
  std::vector<Eigen::Vector3d> reduced;
  const auto take = [&](size_t i) {
    if (!taken[i]) reduced.push_back(vertices[i]);
    taken[i] = true;
  };
  for (int d = 0; d < kExtremeDirections; ++d) {
    const Eigen::Vector3d direction = SphereDirection(d, kExtremeDirections);
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

constexpr std::array kMetrics{
    MetricRow{"mssd", "m", "maximum symmetry-aware surface distance",
              [](const MetricInput& in) { return Mssd(in.model, in.X_est, in.X_true); }},
    MetricRow{"mspd", "px", "maximum symmetry-aware projection distance",
              [](const MetricInput& in) { return Mspd(in.model, in.camera, in.X_est, in.X_true); },
              true},
    MetricRow{"add", "m", "mean distance of equal model points",
              [](const MetricInput& in) { return Add(in.model, in.X_est, in.X_true); }},
    MetricRow{"adi", "m", "mean distance to the closest model point",
              [](const MetricInput& in) { return Adi(in.model, in.X_est, in.X_true); }},
    MetricRow{"rotation", "rad", "angle of the rotation error, least over the symmetries",
              [](const MetricInput& in) { return RotationError(in.model, in.X_est, in.X_true); }},
    MetricRow{
        "translation", "m", "distance of the origins, least over the symmetries",
        [](const MetricInput& in) { return TranslationError(in.model, in.X_est, in.X_true); }},
    MetricRow{kPickRiskMetric, "0..1", "chance that the pick fails, by the part's tolerance map",
              [](const MetricInput& in) { return PickRisk(in.tolerance, in.X_est, in.X_true); }},
};

}  // namespace

MetricModel MakeMetricModel(const ObjectModel& model, int max_vertices) {
  MetricModel metric;
  const auto& vertices = model.mesh_O.vertices;
  const bool all = max_vertices <= 0 || vertices.size() <= static_cast<size_t>(max_vertices);
  metric.vertices_O = all ? vertices : ReducedVertices(vertices, max_vertices);
  metric.symmetries_O = SymmetryTransforms(model.symmetries_O);
  metric.diameter_m = model.diameter_m;
  return metric;
}

Eigen::Vector3d MeanVertex(const MetricModel& model) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : model.vertices_O) sum += vertex;
  return sum / std::max<size_t>(1, model.vertices_O.size());
}

std::span<const MetricRow> MetricTable() { return kMetrics; }

}  // namespace pickbed
