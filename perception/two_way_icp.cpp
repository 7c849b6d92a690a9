#include "perception/two_way_icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "perception/icp_equations.h"
#include "perception/projector.h"
#include "perception/verify.h"

namespace pickbed {
namespace {

// A unit direction in the image plane and how far to go.
struct Sideways {
  Eigen::Vector3f direction_C;
  float distance_m;
};

struct Rows {
  IcpEquations all;
  IcpEquations surface;  // those of the surface alone
  int points = 0;        // of the model that face the camera
  float agreement = 0;   // sum over them
};

class Problem {
 public:
  Problem(const OrganizedCloud& cloud, const ModelPoints& model, const TwoWayIcpOptions& options)
      : cloud_(cloud), model_(model), options_(options), project_(cloud.intrinsics) {}

  Rows Linearize(const CenteredPose& pose, double gate_m) const {
    Rows rows;
    AddModel(pose, static_cast<float>(gate_m), rows);
    AddScene(pose, static_cast<float>(gate_m), rows.all);
    return rows;
  }

 private:
  void AddModel(const CenteredPose& pose, float gate_m, Rows& rows) const {
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    const Eigen::Vector3f center = pose.center_C.cast<float>();
    const float min_cos = static_cast<float>(options_.min_normal_cos);
    const float outline_weight = static_cast<float>(options_.outline_weight);
    const std::vector<uint16_t>& visible = model_.VisibleFrom(ToPose(pose, model_));
    rows.points = std::min(static_cast<int>(visible.size()), options_.max_points);
    for (int i = 0; i < rows.points; ++i) {
      const Eigen::Vector3f arm = R * (model_.points_O[visible[i]] - model_.center_O);
      const Eigen::Vector3f normal = R * model_.normals_O[visible[i]];
      const Eigen::Vector3f p = arm + center;
      const int pixel = project_(p);
      if (pixel < 0 || !(cloud_.depth_m.data()[pixel] > 0)) continue;
      if (Behind(pixel, p.z(), gate_m)) {
        rows.agreement -= 1;
        if (const auto sideways = ToNearestFront(pixel, p.z(), gate_m)) {
          Add(arm, sideways->direction_C, sideways->distance_m, gate_m, outline_weight, rows.all);
        }
        continue;
      }
      const Eigen::Vector3f& seen = cloud_.normals_C[pixel];
      const Eigen::Vector3f d = cloud_.points_C[pixel] - p;
      if (!(seen.dot(normal) > min_cos)) continue;  // also where it is zero
      const float off = seen.dot(d);
      if (std::abs(d.z()) > gate_m || std::abs(off) > gate_m) continue;
      // The points are even over the surface, readings over the image: one counts as many of them
      // as it covers.
      const float facing = std::max(0.0f, -normal.dot(p.normalized()));
      Add(arm, seen, off, gate_m, facing, rows.all);
      Add(arm, seen, off, gate_m, facing, rows.surface);
      rows.agreement += std::pow(1 - off * off / (gate_m * gate_m), 3.0f);
    }
  }

  void AddScene(const CenteredPose& pose, float gate_m, IcpEquations& all) const {
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    const Eigen::Vector3f center = pose.center_C.cast<float>();
    const float weight = static_cast<float>(options_.cover_weight);
    const float reach_m = model_.radius_m + gate_m;
    const PixelBox box = BallPixels(cloud_.intrinsics, center, reach_m);
    const double pixels = static_cast<double>(box.x1 - box.x0) * (box.y1 - box.y0);
    const int stride =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / options_.max_scene_pixels))));
    for (int y = box.y0 + stride / 2; y < box.y1; y += stride) {
      for (int x = box.x0 + stride / 2; x < box.x1; x += stride) {
        if (!cloud_.foreground(x, y)) continue;
        const Eigen::Vector3f arm = cloud_.points_C[y * cloud_.intrinsics.width + x] - center;
        if (arm.squaredNorm() > reach_m * reach_m) continue;
        const Eigen::Vector3f q_O = R.transpose() * arm + model_.center_O;
        const float off = model_.distance.At(q_O);
        if (off >= gate_m) continue;
        const auto away_O = Away(q_O);
        if (away_O) Add(arm, R * *away_O, off, gate_m, weight, all);
      }
    }
  }

  // Where the distance to the surface grows fastest; nothing at the surface itself, where the grid
  // has a dent, half-way between two sides and at the grid's border.
  std::optional<Eigen::Vector3f> Away(const Eigen::Vector3f& q_O) const {
    constexpr float kMinSlope = 0.5f, kMaxSlope = 2;  // 1 in a perfect field
    const float h = 0.5f * model_.distance.cell_m;
    Eigen::Vector3f slope;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3f step = h * Eigen::Vector3f::Unit(axis);
      slope[axis] = (model_.distance.At(q_O + step) - model_.distance.At(q_O - step)) / (2 * h);
    }
    const float norm = slope.norm();
    if (!(norm > kMinSlope && norm < kMaxSlope)) return std::nullopt;
    return slope / norm;
  }

  // Whether the camera sees something well behind z at the pixel. What was taken for the background
  // is another surface for sure, so that less will do.
  bool Behind(int pixel, float z_m, float gate_m) const {
    const float slack_m = cloud_.foreground.data()[pixel] ? gate_m : 0.5f * gate_m;
    return cloud_.depth_m.data()[pixel] > z_m + slack_m;
  }

  // The nearest pixel in eight directions that is not Behind.
  std::optional<Sideways> ToNearestFront(int pixel, float z_m, float gate_m) const {
    const CameraIntrinsics& k = cloud_.intrinsics;
    const int x0 = pixel % k.width, y0 = pixel / k.width;
    const float m_per_px = z_m / static_cast<float>(k.fx);
    std::optional<Sideways> best;
    for (int direction = 0; direction < 9; ++direction) {
      const int dx = direction % 3 - 1, dy = direction / 3 - 1;
      if (dx == 0 && dy == 0) continue;
      const float length = std::sqrt(static_cast<float>(dx * dx + dy * dy));
      const float limit_m = best ? best->distance_m : gate_m;
      for (int step = 1; step * length * m_per_px < limit_m; ++step) {
        const int x = x0 + step * dx, y = y0 + step * dy;
        if (x < 0 || y < 0 || x >= k.width || y >= k.height) break;
        if (Behind(y * k.width + x, z_m, gate_m)) continue;
        best = Sideways{Eigen::Vector3f(dx, dy, 0) / length, step * length * m_per_px};
        break;
      }
    }
    return best;
  }

  // Tukey's biweight: what is about to leave the gate pulls no more.
  void Add(const Eigen::Vector3f& arm, const Eigen::Vector3f& direction, float off_m, float gate_m,
           float weight, IcpEquations& equations) const {
    const float share = off_m / gate_m;
    equations.Add(arm.cross(direction) / model_.radius_m, direction, off_m,
                  (1 - share * share) * std::sqrt(weight));
  }

  const OrganizedCloud& cloud_;
  const ModelPoints& model_;
  const TwoWayIcpOptions& options_;
  Projector project_;
};

struct Gates {
  double start_m, end_m;
};

Gates GatesFor(const ModelPoints& model, const TwoWayIcpOptions& options) {
  const double widest_m = options.gate_diameters * model.diameter_m;
  return {std::min(options.gate_m, widest_m), std::min(options.gate_end_m, widest_m)};
}

CenteredPose Descend(const Problem& problem, const ModelPoints& model, const Gates& gates,
                     const TwoWayIcpOptions& options, CenteredPose pose) {
  for (int i = 0; i < options.iterations; ++i) {
    const double share = (i + 1.0) / options.iterations;
    const double gate_m = gates.start_m * std::pow(gates.end_m / gates.start_m, share);
    const Rows rows = problem.Linearize(pose, gate_m);
    if (!TakeStep(rows.all, options.damping, 2 * gate_m, model.radius_m, pose)) break;
  }
  return pose;
}

double Agreement(const Rows& rows) {
  return rows.points > 0 ? static_cast<double>(rows.agreement) / rows.points : 0.0;
}

std::vector<CenteredPose> Starts(const CenteredPose& start, double turn_rad) {
  std::vector<CenteredPose> starts = {start};
  for (int i = 0; turn_rad > 0 && i < 6; ++i) {
    const double angle = i % 2 == 0 ? turn_rad : -turn_rad;
    const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::Unit(i / 2));
    starts.push_back({turn * start.R_CO, start.center_C});
  }
  return starts;
}

}  // namespace

TwoWayReport TwoWayIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                       const TwoWayIcpOptions& options) {
  const Problem problem(cloud, model, options);
  const Gates gates = GatesFor(model, options);
  const CenteredPose start = ToCentered(X_CO, model);
  CenteredPose best = start;
  Rows rows = problem.Linearize(start, gates.end_m);
  TwoWayReport report;
  report.agreement_before = Agreement(rows);
  report.agreement = report.agreement_before;
  report.made_worse = true;
  for (const CenteredPose& from : Starts(start, options.restart_rad)) {
    const CenteredPose pose = Descend(problem, model, gates, options, from);
    const Rows there = problem.Linearize(pose, gates.end_m);
    if (Agreement(there) < report.agreement || there.surface.pairs < kMinIcpPairs) continue;
    best = pose;
    rows = there;
    report.agreement = Agreement(there);
    report.made_worse = false;
  }
  report.X_CO = report.made_worse ? X_CO : ToPose(best, model);
  if (rows.points > 0) report.overlap = static_cast<double>(rows.surface.pairs) / rows.points;
  if (rows.surface.pairs > 0) {
    report.residual_m = std::sqrt(rows.surface.sum_squared_m2 / rows.surface.pairs);
  }
  if (rows.surface.pairs >= kMinIcpPairs) report.conditioning = Conditioning(rows.surface);
  return report;
}

void RefineTwoWay(const OrganizedCloud& cloud, const ModelPoints& model, PoseHypothesis& hypothesis,
                  const TwoWayIcpOptions& options) {
  const TwoWayReport report = TwoWayIcp(cloud, model, hypothesis.X_CO, options);
  if (!report.made_worse) {
    hypothesis.unrefined_X_CO = hypothesis.X_CO;
    hypothesis.X_CO = report.X_CO;
  }
  hypothesis.fit = MeasureFit(cloud, model, hypothesis.X_CO);
  hypothesis.fit.conditioning = report.conditioning;
  hypothesis.fit.refinement_kept = !report.made_worse;
}

}  // namespace pickbed
