#pragma once

// Plan of a tolerance map: which pose errors are executed, and how the outcomes are stored.

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/runtime/process_pool.h"
#include "grasp/tolerance/tolerance_model.h"
#include "grasp/tolerance/tolerance_trial.h"

namespace pickbed::eval {

inline constexpr char kSamplesFile[] = "samples.csv";

// Axis of a pose error: along or about x, y, z of the object frame O or of the grasp frame G.
// Rotations in O are about the center of the surface, rotations in G about the center of the tips.
struct ErrorAxis {
  const char* name;    // as on the command line
  const char* way;     // "along" or "about"
  const char* unit;    // mm or deg
  bool of_grasp;       // in G, else in O
  int coordinate;      // index in PoseOffset
  double per_unit_si;  // one unit in m or rad
};
// All error axes: six in O, then six in G.
std::span<const ErrorAxis> ErrorAxisTable();
// Meaning of the axis for this gripper, for example "along the closing direction".
std::string AxisHelp(const ErrorAxis& axis, const Gripper& gripper);
// Index into the table. Throws InputError with the nearest name.
int ErrorAxisNamed(const std::string& name);

// Settings of a tolerance study.
struct ToleranceOptions {
  int grasps = 40;         // grasps per error
  double step_mm = 1;      // between errors along an axis
  double step_deg = 3;     // between errors about an axis
  int steps = 10;          // to each side
  int pair_grasps = 12;    // grasps per cell of the map of a pair
  int pair_stride = 2;     // steps between the errors of the map of a pair
  int fit_grasps = 200;    // grasps to which the model is fitted and by which hypotheses are scored
  int fit_samples = 1500;  // random errors on all axes at once, with those grasps in turn
  int test_samples = 1500;  // random errors with separate grasps, to evaluate scores
  // Maximum length of a random error, in steps of the axes.
  double random_steps = 15;
  double keep_share = 0.9;  // share of the success without error that defines the tolerated region
  uint64_t seed = 0;
  std::vector<std::array<int, 2>> pairs;  // of axes, both of O or both of G
  TableOptions table;
  ToleranceFitOptions fit;
  ExecuteOptions execute;
  // Visits all options except `pairs`.
  void Visit(SettingsVisitor& v);
};

// Returns options for a coarse map over the same range in one or two minutes.
ToleranceOptions QuickOptions();

// Purpose of a sample: curve of an axis, map of a pair, fit of the model, test of scores.
enum class SampleKind { kAxis, kPair, kFit, kTest };
// Returns the name of a kind in samples.csv.
const char* SampleKindName(SampleKind kind);

// One execution.
struct PlannedSample {
  SampleKind kind = SampleKind::kAxis;
  std::array<int, 2> axis{-1, -1};  // indices of ErrorAxisTable(); -1 = none
  std::array<int, 2> level{0, 0};   // steps along each axis
  int grasp = 0;
  Pose X_OE = Pose::Identity();  // estimated object frame E in the true one
};

// Result of one execution.
struct SampleOutcome {
  bool success = false;
  FailureReason failure = FailureReason::kPhysicsFailed;
};

// Everything that is fixed before the execution.
struct ToleranceStudy {
  ToleranceOptions options;
  Table table;
  std::vector<TableGrasp> grasps;  // for the map, for the fit, then one for each test sample
  ToleranceModel model;            // surface and symmetries, without weights
  std::vector<PlannedSample> samples;
};

// Draws grasps and errors. Throws InputError like MakeTable, and if no grasp is found in
// `table.max_draws` draws.
ToleranceStudy PlanStudy(std::shared_ptr<const ObjectModel> object,
                         std::shared_ptr<const Gripper> gripper,
                         std::vector<GraspCandidate> candidates, const ToleranceOptions& options);

// Pose error of a sample in G, relative to the nearest symmetric pose.
PoseOffset ErrorInG(const ToleranceStudy& study, const PlannedSample& sample);

// Callbacks of ExecuteStudy. `before` is the number of samples from earlier runs.
struct StudyListener {
  std::function<void(int done, int total, int before)> on_progress;
  std::function<bool()> stop;
};
// Result of ExecuteStudy.
struct StudyOutcomes {
  std::vector<SampleOutcome> outcomes;  // by sample; empty unless all were executed
  bool interrupted = false;
  std::vector<LostItem> lost;
};
// Columns of FOLDER/samples.csv. The first line of the file is a comment that identifies the study.
ResultColumns SamplesColumns();
// Executes the samples that are missing in FOLDER/samples.csv with `jobs` processes, and appends
// each outcome to that file. At the end the file is sorted; it does not depend on `jobs`. Throws
// InputError if the file holds another study, or this study and `resume` is not set.
StudyOutcomes ExecuteStudy(const ToleranceStudy& study, const std::filesystem::path& folder,
                           int jobs, bool resume, const StudyListener& listener);

}  // namespace pickbed::eval
