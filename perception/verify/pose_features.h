#pragma once

// Agreement of a pose with the image: a quick score for thousands of raw hypotheses, and features
// for a learned verifier after ICP. A hole in the depth is unknown, never a violation.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/model/model_points.h"
#include "perception/pose_hypothesis.h"
#include "perception/verify/depth_evidence.h"

namespace pickbed::perception {

// Distance bands, valid up to 1 m; beyond they grow with z^2, as the sensor noise does.
struct VerifyBands {
  double inlier_m = 0.003;      // point-to-plane; about three sigma of the noise at 1 m
  double tight_m = 0.0015;      // limit of a tight inlier
  double explained_m = 0.0035;  // the pose explains scene points this near to the model
  double near_m = 0.008;        // scene points up to here are near but unexplained
  double far_m = 0.014;         // up to here they are far and unexplained; beyond they do not count
  double min_normal_cos = 0.7;
  int max_points = 600;        // the first of the visible model points are used
  int max_scene_pixels = 800;  // of the box around the object, evenly strided
};

// Returns (inliers - violations) / points over at most `max_points` visible points. A point is an
// inlier if its depth differs from the reading by less than tau_m. Does not allocate.
double QuickScore(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                  double tau_m = 0.008, int max_points = 120);

// Number and indices of the verifier's inputs, see ComputeVerifyFeatures().
inline constexpr int kVerifyFeatures = 24;
inline constexpr int kMarginFeature = 11, kAgreeingFeature = 12, kViolatedFeature = 14,
                     kWrongNormalFeature = 15, kOutsideFeature = 16, kRestingFeature = 17,
                     kOverlapFeature = 18, kContinuingFeature = 19;
using VerifyFeatures = std::array<float, kVerifyFeatures>;

// Returns the shares of visible model points that agree, are hidden, or are violated. An inlier is
// on the observed surface, and the normals agree if the pixel has one. Points outside the image
// count as hidden. Holes count in no share. Background at the depth of the model also counts in no
// share, because the lowest few millimetres of an object are removed with the floor. Does not
// allocate.
FitReport MeasureFit(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                     const VerifyBands& bands = {});

// Result of MeasureFit for one visible model point. kUnknown: a hole, or background at its depth.
enum class PointFit : uint8_t { kUnknown, kAgrees, kWrongNormal, kHidden, kViolates };
// One visible model point and its result.
struct JudgedPoint {
  int point = 0;  // index into ModelPoints::points_O
  PointFit fit = PointFit::kUnknown;
};
// Returns the result for each visible model point that MeasureFit counts, for display.
std::vector<JudgedPoint> JudgePoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const VerifyBands& bands = {});

// Computes the verifier's inputs. In order:
// - 0 to 4: inlier, hidden, violated, wrong-normal and tight-inlier shares of the model points
// - 5, 6: near and far unexplained scene points
// - 7, 8: log of the visible points, log of the agreeing raw votes
// - 9: explained scene points
// - 10, 11: evidence per pixel (nats), margin over the best rival
// - 12 to 15: agreeing, hidden, violated and wrong-normal shares of the rendered pixels
// - 16: penetration of the bin, in diameters
// - 17: closeness of the lowest point to the floor, 1 = on it
// - 18: penetration of other hypotheses, in diameters
// - 19: share of the samples beyond the outline where the surface continues
// - 20 to 23: support: weakest and second weakest direction, seen share of the outline, coplanar
//   readings
// Scene points are relative to the pixels that the object would cover without occlusion. Margin and
// penetration of others are 0 here: the caller knows the other hypotheses and fills them. Writes
// the fit shares to `fit`. Does not allocate.
VerifyFeatures ComputeVerifyFeatures(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const DepthEvidence& evidence,
                                     const PoseSupport& support, double agreeing_votes,
                                     FitReport& fit);

// Sets `explained` to 1 at the pixels whose points are on the model surface. `explained` has one
// entry per image pixel.
void MarkExplained(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                   std::vector<uint8_t>& explained);

// Maps the difference in evidence (nats) between a pose and a rival to (-1, 1).
float EvidenceMargin(double log_ratio, double rival_log_ratio);

// Search mode that produced the candidate; selects the calibration. Single-mode estimators use
// kAccurate.
enum class CandidateMode { kAccurate, kFast };
inline constexpr int kCandidateModes = 2;

// Linear correction of a logit.
struct Calibration {
  float scale = 1, shift = 0;
};

// Multilayer perceptron with one hidden tanh layer and standardised inputs.
struct VerifierNetwork {
  Eigen::VectorXf mean, scale;  // per feature; input i is (feature - mean) / scale
  Eigen::MatrixXf w1;           // hidden x features
  Eigen::VectorXf b1, w2;       // one per hidden unit
  float b2 = 0;
  // Returns the logit of the probability that the pose is right, before calibration.
  float Logit(const VerifyFeatures& features) const;
};

// Verifier of one object: a network for images with a known background and one for all others. A
// given bin excludes most of what could be mistaken for an object, so the same features mean less
// without it.
struct Verifier {
  VerifierNetwork known, unknown;
  // By background and mode. In a mode that finds fewer right poses, more candidates with the same
  // features are wrong.
  std::array<std::array<Calibration, kCandidateModes>, kBackgroundKinds> calibrations;
  // Returns the probability that the pose is right.
  double Score(const VerifyFeatures& features, CandidateMode mode = CandidateMode::kAccurate,
               BackgroundKind background = BackgroundKind::kKnown) const;
};

}  // namespace pickbed::perception
