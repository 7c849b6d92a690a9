#pragma once

// Tolerance model: success probability of a pick as a function of the pose error. It is fitted to
// executed grasps (grasp/tolerance/tolerance_trial.h) and scores any hypothesis.
//
// The error of an estimated pose is X_OE = X_WO_true^-1 * X_WO_estimated, the pose of
// the estimated object frame in the true one. In its own frame G, a hand at a grasp X_OG is off by
// X_OG^-1 * X_OE * X_OG. This offset decides the outcome: millimeters along the closing
// direction, across the fingers and along the approach. So the model uses errors in G. A hypothesis
// is scored by the mean over the grasps that would be executed, or by one known grasp.

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "grasp/layer.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_model.h"

namespace pickbed::grasp {

// x, y, z in m, then a rotation vector in rad: R = exp(rotation).
using PoseOffset = Eigen::Matrix<double, 6, 1>;
// Conversion to and from a pose.
Pose ToPose(const PoseOffset& error);
// The rotation angle is at most pi.
PoseOffset ToPoseOffset(const Pose& X);

// One executed grasp: offset of the hand from its pose with the true object pose, and the outcome.
struct ToleranceSample {
  PoseOffset error_G = PoseOffset::Zero();
  bool success = false;
  int grasp = 0;  // index of the grasp
};

// Options of the fit of a tolerance model.
struct ToleranceFitOptions {
  double length_scale_m = 0.010;  // error that gives a scaled coordinate of 1
  double angle_scale_rad = 0.35;
  // Weight of the squared coefficients (ridge) in the penalized log likelihood. `ridges` values are
  // tried, each `ridge_factor` times the previous one. Cross-validation over the grasps with
  // `folds` folds selects the best.
  double min_ridge = 0.3;
  double ridge_factor = 3;
  int ridges = 6;
  int folds = 5;
  int max_steps = 50;       // of Newton's method
  double converged = 1e-8;  // largest change of a coefficient at convergence
  void Visit(SettingsVisitor& v);
};

// Logistic regression (Hosmer and Lemeshow 2013) on magnitudes, squares and products of the six
// coordinates of the error in G. The approach coordinate also enters with its sign, because too
// deep and too high differ.
struct ToleranceModel {
  std::string object;
  std::string gripper;
  double length_scale_m = 0.010;
  double angle_scale_rad = 0.35;
  std::vector<double> weights;  // of the terms in ToleranceTerms()
  std::vector<Pose> X_OG;       // grasps by which a hypothesis is scored
  SymmetrySet symmetries_O;
  // Area-weighted mean and covariance of the surface. They give the mean squared displacement of
  // the surface under a motion.
  Eigen::Vector3d surface_mean_O = Eigen::Vector3d::Zero();
  Eigen::Matrix3d surface_covariance_O = Eigen::Matrix3d::Zero();
  std::vector<Pose> symmetry_inverses_O{Pose::Identity()};  // of symmetries_O, not stored

  void Visit(SettingsVisitor& v);
};

// Returns the inverses of SymmetryTransforms(), in its order.
std::vector<Pose> InverseSymmetries(const SymmetrySet& symmetries);

// Returns the terms of the regression, in the order of the weights, as expressions that Python can
// evaluate: "1", "abs(x)", "x**2", "z*abs(z)", "abs(x*rz)". x, y, z are the position error in G
// over length_scale_m; rx, ry, rz are the rotation vector over angle_scale_rad.
const std::vector<std::string>& ToleranceTerms();

// Returns a model with names, scales, symmetries and surface set, and weights zero. `X_OG` must not
// be empty. Throws InputError for an object whose mesh has no area.
ToleranceModel EmptyToleranceModel(const ObjectModel& model, const std::string& gripper,
                                   std::vector<Pose> X_OG, const ToleranceFitOptions& options = {});

// Fits the weights to the samples. Throws InputError if there are none.
void FitTolerance(const std::vector<ToleranceSample>& samples, const ToleranceFitOptions& options,
                  ToleranceModel& model);

// Error relative to the nearest symmetric equivalent of the true pose: the one with the smallest
// root mean square displacement of the surface.
Pose NearestError(const ToleranceModel& model, const Pose& X_OE);

// Probability that a pick with this pose error succeeds: mean over the grasps of the model.
double SuccessProbability(const ToleranceModel& model, const Pose& X_OE);
// Probability for the grasp at X_OG.
double SuccessProbability(const ToleranceModel& model, const Pose& X_OE, const Pose& X_OG);

// Writes the model as YAML; values read back unchanged.
void WriteToleranceModel(const std::filesystem::path& file, const ToleranceModel& model);
// Reads a model. Throws InputError for an invalid file.
ToleranceModel ReadToleranceModel(const std::filesystem::path& file);

}  // namespace pickbed::grasp
