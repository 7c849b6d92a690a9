#pragma once

// How wrong a pose may be and the pick still succeed, as a function of the error: a model fitted to
// executed grasps (grasp/tolerance_trial.h) that scores any hypothesis.
//
// The error of a believed pose is X_OO = X_WO_true^-1 * X_WO_believed, the pose of the believed
// part in the true one. A hand that trusts it stands, seen in its own frame G, off by
// X_OG^-1 * X_OO * X_OG, which is what decides: millimetres along the closing direction, across
// the fingers, along the approach. So the model is one of errors in G, and a hypothesis is scored
// by its mean over the grasps that would be executed, or for one grasp that is known.

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "scenes/object_model.h"
#include "scenes/settings.h"

namespace pickbed {

// x, y, z in metres, then a turn as rotation vector in radians: R = exp(turn).
using PoseOffset = Eigen::Matrix<double, 6, 1>;
Pose ToPose(const PoseOffset& error);
// The turn is at most half a revolution.
PoseOffset ToPoseOffset(const Pose& X);

// One executed grasp: how far the hand stood from where the truth would have put it.
struct ToleranceSample {
  PoseOffset error_G = PoseOffset::Zero();
  bool success = false;
  int grasp = 0;  // which grasp it was
};

struct ToleranceFitOptions {
  double length_scale_m = 0.010;  // an error of this size is a coordinate of 1
  double angle_scale_rad = 0.35;  // likewise
  // Weight of the squared coefficients beside the log likelihood: of `ridges` values, each
  // `ridge_factor` times the one before, the one that foretells best the grasps that were left out,
  // a fold of them at a time.
  double least_ridge = 0.3;
  double ridge_factor = 3;
  int ridges = 6;
  int folds = 5;
  int max_steps = 50;       // of Newton's method
  double converged = 1e-8;  // largest change of a coefficient at the end
  void Visit(SettingsVisitor& v);
};

// Logistic regression (Hosmer and Lemeshow 2013) on sizes, squares and products of the six
// coordinates of the error in G; the approach also by sign, since too deep is not too high.
struct ToleranceModel {
  std::string object;
  std::string gripper;
  double length_scale_m = 0.010;
  double angle_scale_rad = 0.35;
  std::vector<double> weights;  // of the terms in tolerance.cpp
  std::vector<Pose> X_OG;       // grasps that a hypothesis is scored by
  SymmetrySet symmetries_O;
  // Of the part's surface, by area: what a small motion moves it by in the mean.
  Eigen::Vector3d surface_mean_O = Eigen::Vector3d::Zero();
  Eigen::Matrix3d surface_covariance_O = Eigen::Matrix3d::Zero();
  std::vector<Pose> symmetry_poses_O{Pose::Identity()};  // made of symmetries_O, never stored

  void Visit(SettingsVisitor& v);
};

// Ready but for its weights: names, scales, symmetries and surface. `X_OG` must not be empty.
ToleranceModel EmptyToleranceModel(const ObjectModel& model, const std::string& gripper,
                                   std::vector<Pose> X_OG, const ToleranceFitOptions& options = {});

// Fits the weights. Throws InputError when there are no samples.
void FitTolerance(const std::vector<ToleranceSample>& samples, const ToleranceFitOptions& options,
                  ToleranceModel& model);

// Of the errors against the poses of the true part that look the same, the one that moves the
// part's surface least (root mean square).
Pose NearestError(const ToleranceModel& model, const Pose& X_OtrueObelieved);

// Chance that a pick on the believed pose succeeds. `X_OtrueObelieved` = X_true^-1 * X_believed.
double SuccessProbability(const ToleranceModel& model, const Pose& X_OtrueObelieved);
// The same for the grasp at X_OG alone.
double SuccessProbability(const ToleranceModel& model, const Pose& X_OtrueObelieved,
                          const Pose& X_OG);

// As YAML text; reads back the same. Throws InputError for what is no such file.
void WriteToleranceModel(const std::filesystem::path& file, const ToleranceModel& model);
ToleranceModel ReadToleranceModel(const std::filesystem::path& file);

}  // namespace pickbed
