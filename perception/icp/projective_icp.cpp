#include "perception/icp/projective_icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "perception/icp/normal_equations.h"
#include "perception/icp/projected_points.h"

namespace pickbed::perception {
namespace {

// Selects the visible points that are used.
void Select(const ModelPoints& model, const Pose& X_CO, int max_points, IcpPoints& selected) {
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  selected.count = std::min({static_cast<int>(visible.size()), max_points, kMaxIcpPoints});
  for (int i = 0; i < selected.count; ++i) {
    const Eigen::Vector3f point = model.points_O[visible[i]] - model.center_O;
    for (int k = 0; k < 3; ++k) {
      selected.points[k][i] = point[k];
      selected.normals[k][i] = model.normals_O[visible[i]][k];
    }
  }
}

// Limits of the pairs of a model point and an observed point.
struct PairLimits {
  std::array<int, 5> offsets;  // index offsets of the pixels that are tried, in this order
  float min_normal_cos;
  float max_squared_m2;
  float radius_m;  // of the object
};

// Eight floats: a column of IcpEquations::moments. The compiler splits it if the processor has
// narrower registers.
using Column = float __attribute__((vector_size(8 * sizeof(float))));

// Adds the pairs of the first `count` points to `equations`. Each point is paired with the first of
// its pixels that has a similar normal and is near enough. The variant for AVX2 has no fused
// multiply-add, so that both variants round alike.
__attribute__((target_clones("avx2", "default"))) void AddPairs(const OrganizedCloud& cloud,
                                                                const ProjectedPoints& projected,
                                                                int count, const PairLimits& limits,
                                                                IcpEquations& equations) {
  const auto pixels = static_cast<int>(cloud.normals_C.size());
  const float r = limits.radius_m;
  const Column units = {r, r, r, 1, 1, 1, 1, 1};
  Column moments[7] = {};
  for (int i = 0; i < count; ++i) {
    const int center_pixel = projected.pixels[i];
    if (center_pixel < 0) continue;
    const Eigen::Vector3f model_normal = At(projected.normals_C, i);
    const Eigen::Vector3f p = At(projected.points_C, i);
    for (const int offset : limits.offsets) {
      const int pixel = center_pixel + offset;
      if (pixel < 0 || pixel >= pixels) continue;
      const Eigen::Vector3f& n = cloud.normals_C[pixel];
      if (!(n.dot(model_normal) > limits.min_normal_cos)) continue;  // also where n is zero
      const Eigen::Vector3f d = cloud.points_C[pixel] - p;
      if (d.squaredNorm() > limits.max_squared_m2) continue;
      const float off = n.dot(d);
      const Eigen::Vector3f turn = At(projected.arms, i).cross(n);
      Column row = {turn.x(), turn.y(), turn.z(), n.x(), n.y(), n.z(), off, 0};
      row /= units;
      row *= 1 - off * off / limits.max_squared_m2;  // Tukey's biweight: 0 at the maximum distance
      for (int k = 0; k < 7; ++k) moments[k] += row[k] * row;
      equations.sum_squared_m2 += off * off;
      ++equations.pairs;
      break;
    }
  }
  for (int k = 0; k < 7; ++k) {
    Eigen::Matrix<float, 8, 1> column;
    std::memcpy(column.data(), &moments[k], sizeof(Column));
    equations.moments.col(k) += column;
  }
}

class PlaneProblem {
 public:
  PlaneProblem(const OrganizedCloud& cloud, const ModelPoints& model, double min_normal_cos)
      : cloud_(cloud),
        radius_m_(model.radius_m),
        min_normal_cos_(static_cast<float>(min_normal_cos)) {}

  IcpEquations Linearize(const IcpPoints& points, const CenteredPose& pose,
                         double max_distance_m) const {
    ProjectedPoints projected;
    ProjectPoints(points, pose, cloud_.intrinsics, projected);
    const PairLimits limits{Offsets(max_distance_m, pose.center_C.z()), min_normal_cos_,
                            static_cast<float>(max_distance_m * max_distance_m), radius_m_};
    IcpEquations equations;
    AddPairs(cloud_, projected, points.count, limits, equations);
    return equations;
  }

  IcpStatus Step(const IcpPoints& points, double max_distance_m, double damping,
                 CenteredPose& pose) const {
    return TakeStep(Linearize(points, pose, max_distance_m), damping, 2 * max_distance_m, radius_m_,
                    pose);
  }

 private:
  // Index offsets of the pixel itself and of its four neighbours at half the maximum distance. At
  // the image border some of them are in the next row; their distance rejects them.
  std::array<int, 5> Offsets(double max_distance_m, double z_m) const {
    const CameraIntrinsics& k = cloud_.intrinsics;
    const double reach_px = 0.5 * max_distance_m * k.fx() / z_m;
    const int reach = std::clamp(static_cast<int>(reach_px), 1, k.width());
    return {0, -reach, reach, -reach * k.width(), reach * k.width()};
  }

  const OrganizedCloud& cloud_;
  float radius_m_;
  float min_normal_cos_;
};

}  // namespace

void ProjectiveIcpOptions::Visit(SettingsVisitor& v) {
  v.Real("max_correspondence_distance_m", max_correspondence_distance_m, {1e-5, 1},
         "maximum distance of a correspondence in the first iteration, m");
  v.Real("final_correspondence_distance_m", final_correspondence_distance_m, {1e-5, 1},
         "maximum distance of a correspondence in the last iteration, m");
  v.Integer("coarse_iterations", coarse_iterations, {0, 10000}, "steps with decreasing distance");
  v.Integer("fine_iterations", fine_iterations, {0, 10000}, "steps with the final distance");
  v.Real("min_normal_cos", min_normal_cos, {-1, 1}, "minimum cosine between the normals of a pair");
  v.Integer("max_points", max_points, {6, 512}, "maximum number of model points");
  v.Real("damping", damping, {0, 10},
         "damping, a share of the mean diagonal that is added to the diagonal");
}

IcpResult ProjectiveIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                        const ProjectiveIcpOptions& options) {
  CheckSettings("ProjectiveIcpOptions", options);
  return ProjectiveIcpUnchecked(cloud, model, X_CO, options);
}

IcpResult ProjectiveIcpUnchecked(const OrganizedCloud& cloud, const ModelPoints& model,
                                 const Pose& X_CO, const ProjectiveIcpOptions& options) {
  const PlaneProblem problem(cloud, model, options.min_normal_cos);
  const double first_m = cloud.error_scale * options.max_correspondence_distance_m;
  const double final_m = cloud.error_scale * options.final_correspondence_distance_m;
  CenteredPose pose = ToCentered(X_CO, model);
  IcpPoints points;
  Select(model, X_CO, options.max_points, points);
  IcpResult result;
  result.status = IcpStatus::kRefined;
  const auto step = [&](double max_distance_m) {
    result.status = problem.Step(points, max_distance_m, options.damping, pose);
    result.iterations += result.status == IcpStatus::kRefined;
  };
  for (int i = 0; result.status == IcpStatus::kRefined && i < options.coarse_iterations; ++i) {
    const double share = static_cast<double>(i) / options.coarse_iterations;
    step(first_m + share * (final_m - first_m));
  }
  Select(model, ToPose(pose, model), options.max_points, points);
  for (int i = 0; result.status == IcpStatus::kRefined && i < options.fine_iterations; ++i) {
    step(final_m);
  }
  const IcpEquations end = problem.Linearize(points, pose, final_m);
  result.X_CO = ToPose(pose, model);
  if (points.count > 0) result.inlier_fraction = static_cast<double>(end.pairs) / points.count;
  if (end.pairs > 0) result.rmse_m = std::sqrt(end.sum_squared_m2 / end.pairs);
  if (end.pairs >= kMinIcpPairs) {
    result.reciprocal_condition_number = ReciprocalConditionNumber(end);
  }
  return result;
}

}  // namespace pickbed::perception
