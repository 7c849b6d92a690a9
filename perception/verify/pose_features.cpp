#include "perception/verify/pose_features.h"

#include <algorithm>
#include <cmath>

#include "perception/cloud/projector.h"
#include "perception/verify/physical_consistency.h"

namespace pickbed::perception {
namespace {

struct FitCounts {
  int points = 0;
  int inlier = 0, hidden = 0, violated = 0, wrong_normal = 0, tight = 0;
  double sum_squared_m2 = 0;  // of the inliers
  double cos_sum = 0;         // cosines between the normals and the direction to the camera

  double Share(int count) const { return points > 0 ? static_cast<double>(count) / points : 0.0; }
};

// Sensor noise grows with z^2. Below 1 m the bands do not shrink, because calibration errors
// remain.
float BandScale(double z_m) { return static_cast<float>(std::max(1.0, z_m * z_m)); }

// Counts the point results. If `judged` is given, also appends the result of each point to it.
FitCounts CountFit(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                   const VerifyBands& bands, std::vector<JudgedPoint>* judged = nullptr) {
  // A grazing ray meets a surface far away in depth, although near to its plane. Beyond this many
  // bands the reading is on another surface.
  constexpr float kMaxDepthBands = 4;
  const Projector project(cloud.intrinsics);
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const Eigen::Vector3f center_C = X * model.center_O;
  const Eigen::Vector3f to_camera = -center_C.normalized();
  const float scale = BandScale(center_C.z());
  const float inlier_m = scale * static_cast<float>(bands.inlier_m);
  const float tight_m = scale * static_cast<float>(bands.tight_m);
  const float min_cos = static_cast<float>(bands.min_normal_cos);
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  const auto record = [judged](PointFit fit) {
    if (judged) judged->back().fit = fit;
  };
  FitCounts c;
  c.points = std::min(static_cast<int>(visible.size()), bands.max_points);
  for (int i = 0; i < c.points; ++i) {
    const int index = visible[i];
    if (judged) judged->push_back({index, PointFit::kUnknown});
    const Eigen::Vector3f p = X * model.points_O[index];
    const Eigen::Vector3f n = X.linear() * model.normals_O[index];
    c.cos_sum += std::max(0.0f, n.dot(to_camera));
    const int pixel = project(p);
    if (pixel < 0) {
      ++c.hidden;
      record(PointFit::kHidden);
      continue;
    }
    if (!(cloud.depth_m.data()[pixel] > 0)) continue;
    const Eigen::Vector3f d = cloud.points_C[pixel] - p;
    const float off_plane = n.dot(d);
    if (std::abs(off_plane) >= inlier_m || std::abs(d.z()) >= kMaxDepthBands * inlier_m) {
      ++(d.z() > 0 ? c.violated : c.hidden);
      record(d.z() > 0 ? PointFit::kViolates : PointFit::kHidden);
      continue;
    }
    if (!cloud.foreground.data()[pixel]) continue;
    const Eigen::Vector3f& seen = cloud.normals_C[pixel];
    const bool has_normal = !seen.isZero(0);
    if (has_normal && seen.dot(n) < min_cos) {
      ++c.wrong_normal;
      record(PointFit::kWrongNormal);
      continue;
    }
    ++c.inlier;
    record(PointFit::kAgrees);
    c.tight += has_normal && std::abs(off_plane) < tight_m;
    c.sum_squared_m2 += off_plane * off_plane;
  }
  return c;
}

FitReport ToReport(const FitCounts& c) {
  FitReport fit;
  fit.inlier_share = c.Share(c.inlier);
  fit.hidden_share = c.Share(c.hidden);
  fit.violated_share = c.Share(c.violated);
  if (c.inlier > 0) fit.residual_m = std::sqrt(c.sum_squared_m2 / c.inlier);
  return fit;
}

// Foreground pixels by their distance from the model surface, scaled to the full image.
struct SceneCounts {
  double explained = 0, near = 0, far = 0;
};

SceneCounts CountScene(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                       const VerifyBands& bands) {
  const Eigen::Isometry3f X_OC = X_CO.inverse(Eigen::Isometry).cast<float>();
  const Eigen::Vector3f center_C = (X_CO * model.center_O.cast<double>()).cast<float>();
  const float scale = BandScale(center_C.z());
  const float explained_m = scale * static_cast<float>(bands.explained_m);
  const float near_m = scale * static_cast<float>(bands.near_m);
  const float far_m = scale * static_cast<float>(bands.far_m);
  const float reach_m = model.radius_m + far_m;
  const PixelBox box = BallPixels(cloud.intrinsics, center_C, reach_m);
  const double pixels = static_cast<double>(box.x1 - box.x0) * (box.y1 - box.y0);
  const int stride =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(pixels / bands.max_scene_pixels))));
  SceneCounts counts;
  for (int y = box.y0 + stride / 2; y < box.y1; y += stride) {
    for (int x = box.x0 + stride / 2; x < box.x1; x += stride) {
      if (!cloud.foreground(x, y)) continue;
      const Eigen::Vector3f& q = cloud.points_C[y * cloud.intrinsics.width() + x];
      if ((q - center_C).squaredNorm() > reach_m * reach_m) continue;
      const float d = model.distance.At(X_OC * q);
      counts.explained += d < explained_m;
      counts.near += d >= explained_m && d < near_m;
      counts.far += d >= near_m && d < far_m;
    }
  }
  const double weight = static_cast<double>(stride) * stride;
  return {counts.explained * weight, counts.near * weight, counts.far * weight};
}

// Number of pixels that the unoccluded surface would cover: its projected area.
double ExpectedPixels(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                      const FitCounts& c) {
  if (c.points == 0) return 0;
  const double z = (X_CO * model.center_O.cast<double>()).z();
  const double visible = static_cast<double>(model.VisibleFrom(X_CO).size());
  const double area_m2 = model.area_per_point_m2 * visible * c.cos_sum / c.points;
  return area_m2 * cloud.intrinsics.fx() * cloud.intrinsics.fy() / (z * z);
}

}  // namespace

double QuickScore(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                  double tau_m, int max_points) {
  const Projector project(cloud.intrinsics);
  const Eigen::Isometry3f X = X_CO.cast<float>();
  const float tau = static_cast<float>(tau_m);
  const std::vector<uint16_t>& visible = model.VisibleFrom(X_CO);
  const int count = std::min(static_cast<int>(visible.size()), max_points);
  int balance = 0;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f p = X * model.points_O[visible[i]];
    const int pixel = project(p);
    if (pixel < 0) continue;
    const float seen_m = cloud.depth_m.data()[pixel];
    if (!(seen_m > 0)) continue;
    const float behind = seen_m - p.z();
    if (behind >= tau) {
      --balance;
    } else if (behind > -tau && cloud.foreground.data()[pixel]) {
      ++balance;
    }
  }
  return count > 0 ? static_cast<double>(balance) / count : 0.0;
}

FitReport MeasureFit(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                     const VerifyBands& bands) {
  return ToReport(CountFit(cloud, model, X_CO, bands));
}

std::vector<JudgedPoint> JudgePoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const VerifyBands& bands) {
  std::vector<JudgedPoint> judged;
  CountFit(cloud, model, X_CO, bands, &judged);
  return judged;
}

VerifyFeatures ComputeVerifyFeatures(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const DepthEvidence& evidence,
                                     const PoseSupport& support, double agreeing_votes,
                                     FitReport& fit) {
  constexpr double kMaxPixelShare = 4;  // clamp; tiny silhouettes would give huge values
  constexpr float kMaxInside = 0.25f;   // diameters; larger penetrations are clamped
  constexpr float kNearFloor = 0.05f;   // height in diameters at which the feature is 1/e
  constexpr double kPriorSamples = 8;   // prior count: fewer samples give a small share
  const VerifyBands bands;
  const FitCounts c = CountFit(cloud, model, X_CO, bands);
  const SceneCounts scene = CountScene(cloud, model, X_CO, bands);
  const double expected = std::max(1.0, ExpectedPixels(cloud, model, X_CO, c));
  const auto pixel_share = [&](double pixels) {
    return static_cast<float>(std::min(kMaxPixelShare, pixels / expected));
  };
  const auto of_drawn = [&](double sum) {
    return static_cast<float>(sum / std::max(1.0, evidence.covered));
  };
  const Containment contained = MeasureContainment(cloud, model, X_CO);
  const float height = std::max(0.0f, contained.height_m) / model.diameter_m;
  const bool refinement_kept = fit.refinement_kept;
  fit = ToReport(c);
  fit.refinement_kept = refinement_kept;
  return {static_cast<float>(c.Share(c.inlier)),
          static_cast<float>(c.Share(c.hidden)),
          static_cast<float>(c.Share(c.violated)),
          static_cast<float>(c.Share(c.wrong_normal)),
          static_cast<float>(c.Share(c.tight)),
          pixel_share(scene.near),
          pixel_share(scene.far),
          static_cast<float>(std::log1p(model.VisibleFrom(X_CO).size())),
          static_cast<float>(std::log1p(std::max(0.0, agreeing_votes))),
          pixel_share(scene.explained),
          of_drawn(evidence.log_ratio),
          0.0f,
          of_drawn(evidence.agreeing),
          of_drawn(evidence.hidden),
          of_drawn(evidence.violated),
          of_drawn(evidence.wrong_normal),
          std::min(kMaxInside, contained.outside_m / model.diameter_m),
          contained.has_floor ? std::exp(-height / kNearFloor) : 0.0f,
          0.0f,
          static_cast<float>(evidence.continuing / (evidence.beyond + kPriorSamples)),
          static_cast<float>(support.weakest),
          static_cast<float>(support.second_weakest),
          static_cast<float>(support.outline_seen),
          static_cast<float>(support.coplanar)};
}

void MarkExplained(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                   std::vector<uint8_t>& explained) {
  const Eigen::Isometry3f X_OC = X_CO.inverse(Eigen::Isometry).cast<float>();
  const Eigen::Vector3f center_C = (X_CO * model.center_O.cast<double>()).cast<float>();
  const float explained_m = BandScale(center_C.z()) * static_cast<float>(VerifyBands().explained_m);
  const PixelBox box = BallPixels(cloud.intrinsics, center_C, model.radius_m + explained_m);
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const size_t pixel = static_cast<size_t>(y) * cloud.intrinsics.width() + x;
      if (!cloud.foreground.data()[pixel]) continue;
      if (model.distance.At(X_OC * cloud.points_C[pixel]) < explained_m) explained[pixel] = 1;
    }
  }
}

float EvidenceMargin(double log_ratio, double rival_log_ratio) {
  constexpr double kHalf = 200;  // nats for a margin of one half: about 70 pixels
  const double nats = log_ratio - rival_log_ratio;
  return static_cast<float>(nats / (std::abs(nats) + kHalf));
}

float VerifierNetwork::Logit(const VerifyFeatures& features) const {
  float logit = b2;
  for (Eigen::Index unit = 0; unit < w1.rows(); ++unit) {
    float sum = b1[unit];
    for (Eigen::Index i = 0; i < w1.cols(); ++i) {
      sum += w1(unit, i) * (features[i] - mean[i]) / scale[i];
    }
    logit += w2[unit] * std::tanh(sum);
  }
  return logit;
}

double Verifier::Score(const VerifyFeatures& features, CandidateMode mode,
                       BackgroundKind background) const {
  const VerifierNetwork& network = background == BackgroundKind::kKnown ? known : unknown;
  const Calibration& calibration =
      calibrations[static_cast<size_t>(background)][static_cast<size_t>(mode)];
  const float logit = calibration.scale * network.Logit(features) + calibration.shift;
  return 1.0 / (1.0 + std::exp(-static_cast<double>(logit)));
}

}  // namespace pickbed::perception
