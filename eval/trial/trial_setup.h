#pragma once

// Cell, gripper, estimator and grasp candidates that a worker uses for all trials of one scenario.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "eval/cell/simulated_cell.h"
#include "eval/metrics/pose_errors.h"
#include "eval/trial/estimator_runner.h"
#include "eval/trial/stage_oracle.h"
#include "grasp/execute/execute.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/grippers/tools.h"
#include "grasp/planners/table.h"
#include "scenes/base/settings.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

class SegmentShapes;  // eval/shapes/segment_shapes.h

// How the runner chooses among planned grasps.
struct TrialOptions {
  // After a failed pick, a grasp of the same object is not repeated if the estimated position is
  // within `retry_radius_m` of the failed one and the approach within `retry_angle_rad`: an
  // unchanged bin gives the same failure. Such a grasp becomes the last choice once another
  // instance was picked.
  double retry_radius_m = 0.02;
  double retry_angle_rad = 0.35;
  int retry_grasps = 200;   // grasps planned after a failure, to choose from
  int cloud_stride_px = 2;  // step of the observed points that the planner keeps clear of
  double match_diameters = kMatchDiameters;  // MSSD within which a hypothesis matches an instance
  OracleStages truth;                        // stages with ground truth substituted
  int true_grasps = 10;                      // grasps tried in the true scene if truth.grasp is set
  // Whether the estimator is made by the first attempt that needs it, not by the constructor.
  bool estimator_on_demand = false;
  std::filesystem::path log_dir;  // for the output of other programs; empty = not kept
  // Called when another program failed, with one line. May be empty.
  std::function<void(const std::string& line)> on_warning;
  // Visits all options except `truth`, `estimator_on_demand`, `log_dir` and `on_warning`.
  void Visit(SettingsVisitor& v);
};

struct TrialSetup {
  // Called while codebooks are made and after each attempt, with the work and the share done.
  using Progress = std::function<void(std::string_view what, double share)>;

  // Makes the estimator, the grasp candidates and the planner, from caches where possible. Throws
  // InputError for an unknown estimator, gripper, sensor, planner or policy, for a broken model
  // file, for options out of range, and for settings that the planner cannot follow.
  TrialSetup(const ScenarioSpec& scenario, const ObjectSet& objects, const Progress& on_progress,
             const TrialOptions& trial_options);

  // Makes the estimator and the refiner, unless they exist or the trial needs none. Throws as the
  // constructor.
  void MakeEstimator();
  // Continues with the bins of another seed of the scenario. Throws InputError as
  // RequireSizesFit().
  void SetSeed(uint64_t seed);

  ScenarioSpec spec;
  TrialOptions options;
  Progress on_progress;
  SimulatedCell cell;
  Tools tools;
  ExecuteOptions execute;
  std::vector<MetricModel> metric_models;  // by object
  // By tool and object; none for distractors, for objects that the tool cannot hold, and without a
  // pose stage.
  std::vector<std::vector<std::vector<GraspCandidate>>> candidates;
  std::shared_ptr<SegmentShapes> shapes;  // null: the planner needs none
  std::unique_ptr<Planner> planner;
  bool has_poses = true;  // false: the planner works without poses, and there is no pose stage
  // Null: the oracle, all of perception is given, or there is no pose stage.
  std::unique_ptr<EstimatorRunner> estimator;
  std::unique_ptr<OracleRefiner> refiner;  // refines substituted poses; may be null
  bool has_estimator = false;              // MakeEstimator() was called
};

// Returns the planner of a trial: the row of the scenario, or the planner on poses if the poses of
// all instances are given. Throws InputError for an unknown planner. Throws it for a planner
// without poses together with a setting that needs poses: an occlusion scenario, several picks per
// image, a lift check, another ranking than the default, or a stage oracle of a pose stage.
const PlannerRow& PlannerOf(const ScenarioSpec& scenario, const OracleStages& truth);

}  // namespace pickbed::eval
