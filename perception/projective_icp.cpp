#include "perception/projective_icp.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/icp_equations.h"
#include "perception/projector.h"

namespace pickbed {
namespace {

constexpr int kMaxPoints = 512;

// The visible points that take part, about the part's centre.
struct Subset {
  int count = 0;
  std::array<Eigen::Vector3f, kMaxPoints> points, normals;
};

void Select(const ModelPoints& model, const Pose& X_CO, int max_points, Subset& subset) {
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  subset.count = std::min({static_cast<int>(visible.size()), max_points, kMaxPoints});
  for (int i = 0; i < subset.count; ++i) {
    subset.points[i] = model.points_O[visible[i]] - model.center_O;
    subset.normals[i] = model.normals_O[visible[i]];
  }
}

class Problem {
 public:
  Problem(const OrganizedCloud& cloud, const ModelPoints& model, double min_normal_cos)
      : cloud_(cloud),
        project_(cloud.intrinsics),
        radius_m_(model.radius_m),
        min_normal_cos_(static_cast<float>(min_normal_cos)) {}

  IcpEquations Linearize(const Subset& subset, const CenteredPose& pose, double gate_m) const {
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    const Eigen::Vector3f center = pose.center_C.cast<float>();
    const std::array<int, 5> offsets = Offsets(gate_m, pose.center_C.z());
    const auto pixels = static_cast<int>(cloud_.normals_C.size());
    const float gate2 = static_cast<float>(gate_m * gate_m);
    IcpEquations equations;
    for (int i = 0; i < subset.count; ++i) {
      const Eigen::Vector3f arm = R * subset.points[i];
      const Eigen::Vector3f model_normal = R * subset.normals[i];
      const Eigen::Vector3f p = arm + center;
      const int middle = project_(p);
      if (middle < 0) continue;
      for (const int offset : offsets) {
        const int pixel = middle + offset;
        if (pixel < 0 || pixel >= pixels) continue;
        const Eigen::Vector3f& n = cloud_.normals_C[pixel];
        if (!(n.dot(model_normal) > min_normal_cos_)) continue;  // also where n is zero
        const Eigen::Vector3f d = cloud_.points_C[pixel] - p;
        if (d.squaredNorm() > gate2) continue;
        // Tukey's biweight: what is about to leave the gate pulls no more.
        const float off = n.dot(d);
        equations.Add(arm.cross(n) / radius_m_, n, off, 1 - off * off / gate2);
        break;
      }
    }
    return equations;
  }

  bool Step(const Subset& subset, double gate_m, double damping, CenteredPose& pose) const {
    return TakeStep(Linearize(subset, pose, gate_m), damping, 2 * gate_m, radius_m_, pose);
  }

 private:
  // The pixel itself and, where that is no partner, those half a gate beside it. (At the image's
  // border some of them are in the next row; the gate sees to that.)
  std::array<int, 5> Offsets(double gate_m, double z_m) const {
    const CameraIntrinsics& k = cloud_.intrinsics;
    const double reach_px = 0.5 * gate_m * k.fx / z_m;
    const int reach = std::clamp(static_cast<int>(reach_px), 1, k.width);
    return {0, -reach, reach, -reach * k.width, reach * k.width};
  }

  const OrganizedCloud& cloud_;
  Projector project_;
  float radius_m_;
  float min_normal_cos_;
};

}  // namespace

IcpReport ProjectiveIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                        const ProjectiveIcpOptions& options) {
  const Problem problem(cloud, model, options.min_normal_cos);
  CenteredPose pose = ToCentered(X_CO, model);
  Subset subset;
  Select(model, X_CO, options.max_points, subset);
  bool ok = true;
  for (int i = 0; ok && i < options.coarse_iterations; ++i) {
    const double share = static_cast<double>(i) / options.coarse_iterations;
    const double gate = options.gate_m + share * (options.gate_end_m - options.gate_m);
    ok = problem.Step(subset, gate, options.damping, pose);
  }
  Select(model, ToPose(pose, model), options.max_points, subset);
  for (int i = 0; ok && i < options.fine_iterations; ++i) {
    ok = problem.Step(subset, options.gate_end_m, options.damping, pose);
  }
  const IcpEquations end = problem.Linearize(subset, pose, options.gate_end_m);
  IcpReport report;
  report.X_CO = ToPose(pose, model);
  if (subset.count > 0) report.overlap = static_cast<double>(end.pairs) / subset.count;
  if (end.pairs > 0) report.residual_m = std::sqrt(end.sum_squared_m2 / end.pairs);
  if (end.pairs >= kMinIcpPairs) report.conditioning = Conditioning(end);
  return report;
}

}  // namespace pickbed
