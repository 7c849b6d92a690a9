#include "perception/icp/bidirectional_icp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "perception/cloud/projector.h"
#include "perception/icp/normal_equations.h"

namespace pickbed::perception {
namespace {

// A displacement parallel to the image plane: unit direction and distance.
struct Sideways {
  Eigen::Vector3f direction_C;
  float distance_m;
};

struct Rows {
  IcpEquations all;
  IcpEquations surface;  // surface residuals only
  int points = 0;        // visible model points used
  float agreement = 0;   // sum over these points
};

class BidirectionalProblem {
 public:
  BidirectionalProblem(const OrganizedCloud& cloud, const ModelPoints& model,
                       const BidirectionalIcpOptions& options)
      : cloud_(cloud), model_(model), options_(options), project_(cloud.intrinsics) {}

  Rows Linearize(const CenteredPose& pose, double max_distance_m) const {
    Rows rows;
    AddModel(pose, static_cast<float>(max_distance_m), rows);
    AddScene(pose, static_cast<float>(max_distance_m), rows.all);
    return rows;
  }

 private:
  void AddModel(const CenteredPose& pose, float max_distance_m, Rows& rows) const {
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
      if (Behind(pixel, p.z(), max_distance_m)) {
        rows.agreement -= 1;
        if (const auto sideways = ToNearestFront(pixel, p.z(), max_distance_m)) {
          Add(arm, sideways->direction_C, sideways->distance_m, max_distance_m, outline_weight,
              rows.all);
        }
        continue;
      }
      const Eigen::Vector3f& seen = cloud_.normals_C[pixel];
      const Eigen::Vector3f d = cloud_.points_C[pixel] - p;
      if (!(seen.dot(normal) > min_cos)) continue;  // also where it is zero
      const float off = seen.dot(d);
      if (std::abs(d.z()) > max_distance_m || std::abs(off) > max_distance_m) continue;
      // Model points are even over the surface, readings over the image. The weight is proportional
      // to the image area that the point covers.
      const float facing = std::max(0.0f, -normal.dot(p.normalized()));
      Add(arm, seen, off, max_distance_m, facing, rows.all);
      Add(arm, seen, off, max_distance_m, facing, rows.surface);
      rows.agreement += std::pow(1 - off * off / (max_distance_m * max_distance_m), 3.0f);
    }
  }

  void AddScene(const CenteredPose& pose, float max_distance_m, IcpEquations& all) const {
    const Eigen::Matrix3f R = pose.R_CO.cast<float>();
    const Eigen::Vector3f center = pose.center_C.cast<float>();
    const float weight = static_cast<float>(options_.cover_weight);
    const float reach_m = model_.radius_m + max_distance_m;
    const PixelBox box = BallPixels(cloud_.intrinsics, center, reach_m);
    const double pixels = static_cast<double>(box.x1 - box.x0) * (box.y1 - box.y0);
    const int stride =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / options_.max_scene_pixels))));
    for (int y = box.y0 + stride / 2; y < box.y1; y += stride) {
      for (int x = box.x0 + stride / 2; x < box.x1; x += stride) {
        if (!cloud_.foreground(x, y)) continue;
        const Eigen::Vector3f arm = cloud_.points_C[y * cloud_.intrinsics.width() + x] - center;
        if (arm.squaredNorm() > reach_m * reach_m) continue;
        const Eigen::Vector3f q_O = R.transpose() * arm + model_.center_O;
        const float off = model_.distance.At(q_O);
        if (off >= max_distance_m) continue;
        const auto away_O = Away(q_O);
        if (away_O) Add(arm, R * *away_O, off, max_distance_m, weight, all);
      }
    }
  }

  // Unit gradient of the distance field. Returns nothing where the gradient is unreliable: at the
  // surface, half-way between two sides, and at the border of the grid.
  std::optional<Eigen::Vector3f> Away(const Eigen::Vector3f& q_O) const {
    constexpr float kMinSlope = 0.5f, kMaxSlope = 2;  // an exact field has slope 1
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

  // Whether the reading at the pixel is clearly behind z_m. Background is certainly another
  // surface, so it needs only half the distance.
  bool Behind(int pixel, float z_m, float max_distance_m) const {
    const float slack_m = cloud_.foreground.data()[pixel] ? max_distance_m : 0.5f * max_distance_m;
    return cloud_.depth_m.data()[pixel] > z_m + slack_m;
  }

  // Returns the way to the nearest pixel, in eight directions, that is not Behind().
  std::optional<Sideways> ToNearestFront(int pixel, float z_m, float max_distance_m) const {
    const CameraIntrinsics& k = cloud_.intrinsics;
    const int x0 = pixel % k.width(), y0 = pixel / k.width();
    const float m_per_px = z_m / static_cast<float>(k.fx());
    std::optional<Sideways> best;
    for (int direction = 0; direction < 9; ++direction) {
      const int dx = direction % 3 - 1, dy = direction / 3 - 1;
      if (dx == 0 && dy == 0) continue;
      const float length = std::sqrt(static_cast<float>(dx * dx + dy * dy));
      const float limit_m = best ? best->distance_m : max_distance_m;
      for (int step = 1; step * length * m_per_px < limit_m; ++step) {
        const int x = x0 + step * dx, y = y0 + step * dy;
        if (x < 0 || y < 0 || x >= k.width() || y >= k.height()) break;
        if (Behind(y * k.width() + x, z_m, max_distance_m)) continue;
        best = Sideways{Eigen::Vector3f(dx, dy, 0) / length, step * length * m_per_px};
        break;
      }
    }
    return best;
  }

  // Tukey's biweight: the weight is zero at the maximum distance.
  void Add(const Eigen::Vector3f& arm, const Eigen::Vector3f& direction, float off_m,
           float max_distance_m, float weight, IcpEquations& equations) const {
    const float share = off_m / max_distance_m;
    equations.Add(arm.cross(direction) / model_.radius_m, direction, off_m,
                  (1 - share * share) * std::sqrt(weight));
  }

  const OrganizedCloud& cloud_;
  const ModelPoints& model_;
  const BidirectionalIcpOptions& options_;
  Projector project_;
};

// Maximum correspondence distances at the start and at the end.
struct DistanceLimits {
  double start_m, end_m;
};

DistanceLimits LimitsFor(const ModelPoints& model, double error_scale,
                         const BidirectionalIcpOptions& options) {
  const double largest_m = options.max_correspondence_distance_diameters * model.diameter_m;
  return {std::min(error_scale * options.max_correspondence_distance_m, largest_m),
          std::min(error_scale * options.final_correspondence_distance_m, largest_m)};
}

// The pose after some iterations, and their number.
struct Descent {
  CenteredPose pose;
  int iterations = 0;
};

Descent Descend(const BidirectionalProblem& problem, const ModelPoints& model,
                const DistanceLimits& limits, const BidirectionalIcpOptions& options,
                const CenteredPose& start) {
  Descent descent{start};
  for (int i = 0; i < options.iterations; ++i) {
    const double share = (i + 1.0) / options.iterations;
    const double max_distance_m = limits.start_m * std::pow(limits.end_m / limits.start_m, share);
    const Rows rows = problem.Linearize(descent.pose, max_distance_m);
    const IcpStatus status =
        TakeStep(rows.all, options.damping, 2 * max_distance_m, model.radius_m, descent.pose);
    if (status != IcpStatus::kRefined) break;
    ++descent.iterations;
  }
  return descent;
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

void BidirectionalIcpOptions::Visit(SettingsVisitor& v) {
  v.Real("max_correspondence_distance_m", max_correspondence_distance_m, {1e-5, 1},
         "maximum distance of a residual in the first iteration, m");
  v.Real("final_correspondence_distance_m", final_correspondence_distance_m, {1e-5, 1},
         "maximum distance of a residual in the last iteration, m");
  v.Real("max_correspondence_distance_diameters", max_correspondence_distance_diameters, {1e-3, 10},
         "upper limit of both distances, diameters");
  v.Integer("iterations", iterations, {0, 10000}, "maximum number of steps");
  v.Real("min_normal_cos", min_normal_cos, {-1, 1}, "minimum cosine between the normals of a pair");
  v.Real("outline_weight", outline_weight, {0, 1000}, "weight of outline residuals");
  v.Real("cover_weight", cover_weight, {0, 1000}, "weight of cover residuals");
  v.Real("damping", damping, {0, 10},
         "damping, a share of the mean diagonal that is added to the diagonal");
  v.Integer("max_points", max_points, {6, 100000}, "maximum number of model points");
  v.Integer("max_scene_pixels", max_scene_pixels, {1, 10000000}, "maximum number of pixels");
  v.Real("restart_rad", restart_rad, {0, 3.2}, "rotation of the additional starts, rad; 0 = none");
}

IcpResult BidirectionalIcp(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                           const BidirectionalIcpOptions& options) {
  CheckSettings("BidirectionalIcpOptions", options);
  const BidirectionalProblem problem(cloud, model, options);
  const DistanceLimits limits = LimitsFor(model, cloud.error_scale, options);
  const CenteredPose start = ToCentered(X_CO, model);
  CenteredPose best = start;
  Rows rows = problem.Linearize(start, limits.end_m);
  IcpResult result;
  result.start_agreement = result.agreement = Agreement(rows);
  for (const CenteredPose& from : Starts(start, options.restart_rad)) {
    const Descent descent = Descend(problem, model, limits, options, from);
    const Rows there = problem.Linearize(descent.pose, limits.end_m);
    if (there.surface.pairs < kMinIcpPairs) continue;
    if (Agreement(there) < result.agreement) {
      if (result.status != IcpStatus::kRefined) result.status = IcpStatus::kWorse;
      continue;
    }
    best = descent.pose;
    rows = there;
    result.agreement = Agreement(there);
    result.iterations = descent.iterations;
    result.status = IcpStatus::kRefined;
  }
  result.X_CO = result.status == IcpStatus::kRefined ? ToPose(best, model) : X_CO;
  const IcpEquations& surface = rows.surface;
  if (rows.points > 0) result.inlier_fraction = static_cast<double>(surface.pairs) / rows.points;
  if (surface.pairs > 0) result.rmse_m = std::sqrt(surface.sum_squared_m2 / surface.pairs);
  if (surface.pairs >= kMinIcpPairs) {
    result.reciprocal_condition_number = ReciprocalConditionNumber(surface);
  }
  return result;
}

}  // namespace pickbed::perception
