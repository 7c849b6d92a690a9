#pragma once

// How well a pose explains the image: a quick score for thousands of raw hypotheses, and a learned
// verifier for those that survive ICP. A hole in the depth is unknown, never a violation.

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/depth_evidence.h"
#include "perception/depth_to_cloud.h"
#include "perception/model_points.h"
#include "perception/pose_hypothesis.h"

namespace pickbed {

// Bands for distances at up to 1 m; they grow with z^2 beyond, as the sensor's noise does.
struct VerifyBands {
  double inlier_m = 0.003;      // point-to-plane; about three sigma of the noise at 1 m
  double tight_m = 0.0015;      // of a tight inlier
  double explained_m = 0.0035;  // a scene point this near to the model is explained by it
  double near_m = 0.008;        // up to here it is near but unexplained ...
  double far_m = 0.014;         // ... and up to here farther; beyond it is another matter
  double min_normal_cos = 0.7;
  int max_points = 600;        // the first of the visible model points
  int max_scene_pixels = 800;  // of the box around the part, evenly strided
};

// (inliers - violations) / points over at most `max_points` visible points, band tau_m. No
// allocation.
double QuickScore(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                  double tau_m = 0.008, int max_points = 120);

inline constexpr int kVerifyFeatures = 20;
inline constexpr int kMarginFeature = 11, kAgreeingFeature = 12, kViolatedFeature = 14,
                     kWrongNormalFeature = 15, kOutsideFeature = 16, kRestingFeature = 17,
                     kOverlapFeature = 18, kContinuingFeature = 19;
using VerifyFeatures = std::array<float, kVerifyFeatures>;

// Shares of the visible model points. An inlier lies on the surface seen; where the pixel has a
// normal it agrees. Holes count in none of the shares; points outside the image are hidden. Where
// the camera sees the background at the model's depth the point counts in none, either: a part's
// lowest few millimetres are cut off with the floor. No allocation.
FitReport MeasureFit(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                     const VerifyBands& bands = {});

// What MeasureFit finds of one visible model point. Unknown: a hole, or background at its depth.
enum class PointFit : uint8_t { kUnknown, kAgrees, kWrongNormal, kHidden, kViolates };
struct JudgedPoint {
  int point = 0;  // index into ModelPoints::points_O
  PointFit fit = PointFit::kUnknown;
};
// The visible model points that MeasureFit and the features count, one by one, to be looked at.
std::vector<JudgedPoint> JudgePoints(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const VerifyBands& bands = {});

// In order: inlier, hidden, violated, wrong-normal and tight-inlier shares; near and farther
// unexplained scene points; log visible points; log agreeing raw votes; explained share; evidence a
// pixel; margin; agreeing, hidden, violated and wrong-normal shares of the pixels drawn; how far it
// reaches out of the bin, in diameters; how near its lowest point is to the floor, 1 = on it; how
// deep it lies in others, in diameters; the share of the looks beyond its outline that see its
// surface go on. The counts of scene points are over the pixels that the
// part would cover were it not hidden. Margin and overlap are for the caller to fill, who knows the
// others; they are 0. No allocation.
VerifyFeatures ComputeVerifyFeatures(const OrganizedCloud& cloud, const ModelPoints& model,
                                     const Pose& X_CO, const DepthEvidence& evidence,
                                     double agreeing_votes, FitReport& fit);

// Sets the pixels whose points lie on the model's surface, in an array of the image's size.
void MarkExplained(const OrganizedCloud& cloud, const ModelPoints& model, const Pose& X_CO,
                   std::vector<uint8_t>& explained);

// By how much the evidence for a pose exceeds that for a rival, in nats, between -1 and 1.
float EvidenceMargin(double log_ratio, double rival_log_ratio);

// Whose candidates a score is of. A method of one mode is of the first.
enum class CandidateMode { kHard, kFast };
inline constexpr int kCandidateModes = 2;

struct Calibration {
  float scale = 1, shift = 0;  // of a logit
};

// A perceptron with tanh and one hidden layer, inputs standardised; output P(pose right).
struct Verifier {
  Eigen::VectorXf mean, scale;  // a feature each; input i is (feature - mean) / scale
  Eigen::MatrixXf w1;           // hidden x features
  Eigen::VectorXf b1, w2;       // hidden
  float b2 = 0;
  // A mode that finds fewer right poses has more wrong ones of equal features.
  std::array<Calibration, kCandidateModes> calibrations;
  double Score(const VerifyFeatures& features, CandidateMode mode = CandidateMode::kHard) const;
};

}  // namespace pickbed
