#include "perception/projective_icp.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "perception/projector.h"

namespace pickbed {
namespace {

constexpr int kMaxPoints = 512;
constexpr int kMinPairs = 6;  // as many as unknowns

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

// Pose by rotation and the place of the part's centre: turns about the centre keep the normal
// equations well scaled.
struct CenteredPose {
  Eigen::Matrix3d R_CO;
  Eigen::Vector3d center_C;
};

using Matrix6f = Eigen::Matrix<float, 6, 6>;
using Vector6f = Eigen::Matrix<float, 6, 1>;
using Vector8f = Eigen::Matrix<float, 8, 1>;

// Normal equations of the weighted sum of (n . (q - p))^2 over the pairs: the moments of rows
// (J, residual), in columns of eight for the sake of vector instructions.
struct Equations {
  Eigen::Matrix<float, 8, 7> moments = Eigen::Matrix<float, 8, 7>::Zero();
  float sum_squared_m2 = 0;  // not weighted
  int pairs = 0;

  // Weight (1 - r^2 / gate^2)^2, Tukey's biweight: what is about to leave the gate pulls no more.
  void Add(const Eigen::Vector3f& turn, const Eigen::Vector3f& normal, float residual,
           float gate2) {
    const float root = 1 - residual * residual / gate2;
    Vector8f row;
    row << turn, normal, residual, 0;
    row *= root;
    for (int i = 0; i < 7; ++i) moments.col(i) += row[i] * row;
    sum_squared_m2 += residual * residual;
    ++pairs;
  }
  Matrix6f hessian() const { return moments.topLeftCorner<6, 6>(); }
  Vector6f gradient() const { return moments.col(6).head<6>(); }
};

class Problem {
 public:
  Problem(const OrganizedCloud& cloud, const ModelPoints& model, double min_normal_cos)
      : cloud_(cloud),
        project_(cloud.intrinsics),
        radius_m_(model.radius_m),
        min_normal_cos_(static_cast<float>(min_normal_cos)) {}

  Equations Linearize(const Subset& subset, const CenteredPose& pose, double gate_m) const {
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    const Eigen::Vector3f center = pose.center_C.cast<float>();
    const std::array<int, 5> offsets = Offsets(gate_m, pose.center_C.z());
    const auto pixels = static_cast<int>(cloud_.normals_C.size());
    const float gate2 = static_cast<float>(gate_m * gate_m);
    Equations equations;
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
        equations.Add(arm.cross(n) / radius_m_, n, n.dot(d), gate2);
        break;
      }
    }
    return equations;
  }

  // One damped Gauss-Newton step. False: too few pairs, or a step beyond the gate, after which
  // the pairs mean nothing.
  bool Step(const Subset& subset, double gate_m, double damping, CenteredPose& pose) const {
    const Equations equations = Linearize(subset, pose, gate_m);
    if (equations.pairs < kMinPairs) return false;
    Matrix6f hessian = equations.hessian();
    hessian.diagonal().array() += static_cast<float>(damping) * hessian.trace() / 6;
    const Vector6f x = hessian.ldlt().solve(equations.gradient());
    const Eigen::Vector3d turn = x.head<3>().cast<double>() / radius_m_;
    const Eigen::Vector3d move = x.tail<3>().cast<double>();
    if (!(move.norm() + turn.norm() * radius_m_ < 2 * gate_m)) return false;
    const double angle = turn.norm();
    if (angle > 0) pose.R_CO = Eigen::AngleAxisd(angle, turn / angle) * pose.R_CO;
    pose.center_C += move;
    return true;
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

Pose ToPose(const CenteredPose& c, const ModelPoints& model) {
  Pose X_CO = Pose::Identity();
  X_CO.linear() = Eigen::Quaterniond(c.R_CO).normalized().toRotationMatrix();
  X_CO.translation() = c.center_C - X_CO.linear() * model.center_O.cast<double>();
  return X_CO;
}

double Conditioning(const Matrix6f& hessian) {
  const Eigen::SelfAdjointEigenSolver<Matrix6f> solver(hessian, Eigen::EigenvaluesOnly);
  const float largest = solver.eigenvalues()[5];
  return largest > 0 ? std::max(0.0f, solver.eigenvalues()[0]) / largest : 0.0;
}

}  // namespace

IcpReport ProjectiveIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                        const ProjectiveIcpOptions& options) {
  const Problem problem(cloud, model, options.min_normal_cos);
  CenteredPose pose{X_CO.linear(), X_CO * model.center_O.cast<double>()};
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
  const Equations end = problem.Linearize(subset, pose, options.gate_end_m);
  IcpReport report;
  report.X_CO = ToPose(pose, model);
  if (subset.count > 0) report.overlap = static_cast<double>(end.pairs) / subset.count;
  if (end.pairs > 0) report.residual_m = std::sqrt(end.sum_squared_m2 / end.pairs);
  if (end.pairs >= kMinPairs) report.conditioning = Conditioning(end.hessian());
  return report;
}

}  // namespace pickbed
