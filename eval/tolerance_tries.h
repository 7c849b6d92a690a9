#pragma once

// Which pose errors a tolerance map executes, and how the outcomes are kept.

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/workers.h"
#include "grasp/tolerance.h"
#include "grasp/tolerance_trial.h"

namespace pickbed {

// An axis of the error: along or about x, y, z of the object's frame O, or of the grasp's frame G.
// Turns are about the middle of the part's surface in O, about the middle of the tips in G.
struct ErrorAxis {
  const char* name;    // as on the command line
  const char* way;     // "along" or "about"
  const char* unit;    // mm or deg
  bool of_grasp;       // else of O
  int coordinate;      // of the PoseOffset
  double per_unit_si;  // m or rad in one unit
};
std::span<const ErrorAxis> ErrorAxisTable();
// "along the closing direction": what the axis is with this gripper.
std::string AxisHelp(const ErrorAxis& axis, const GripperSpec& gripper);
// Index into the table; InputError with the nearest name.
int ErrorAxisNamed(const std::string& name);

struct ToleranceOptions {
  int grasps = 40;        // that each error is executed with
  double step_mm = 1;     // of the errors along an axis
  double step_deg = 3;    // and about one
  int steps = 10;         // to each side
  int pair_grasps = 12;   // grasps of a pair's map
  int pair_stride = 2;    // steps between the errors of a pair's map
  int fit_grasps = 200;   // that the model is fitted to and that hypotheses are scored by
  int fit_tries = 1500;   // of random errors on all axes at once, with those grasps in turn
  int test_tries = 1500;  // likewise with grasps of their own, to judge scores by
  // A random error is this many steps long at most, counted in the steps of the axes.
  double random_steps = 15;
  double keep_share = 0.9;  // of the success without an error that a region of errors keeps
  uint64_t seed = 0;
  std::vector<std::array<int, 2>> pairs;  // of axes, both of O or both of G
  TableOptions table;
  ToleranceFitOptions fit;
  ExecuteOptions execute;
  // All but the pairs.
  void Visit(SettingsVisitor& v);
};

enum class TryKind { kAxis, kPair, kFit, kTest };
const char* TryKindName(TryKind kind);

// One execution.
struct ToleranceTry {
  TryKind kind = TryKind::kAxis;
  std::array<int, 2> axis{-1, -1};  // of the table; -1 = none
  std::array<int, 2> level{0, 0};   // steps along each
  int grasp = 0;
  Pose X_OO = Pose::Identity();  // the believed part in the true one
};

struct TryOutcome {
  bool success = false;
  Loss loss = Loss::kPhysicsFailed;
};

// All that is fixed before anything is executed.
struct ToleranceStudy {
  ToleranceOptions options;
  Table table;
  std::vector<TableGrasp> grasps;  // of the map, of the fit, then one each of the test
  ToleranceModel model;            // without weights: surface and symmetries
  std::vector<ToleranceTry> tries;
};

// Draws grasps and errors. Throws InputError as MakeTable does.
ToleranceStudy PlanStudy(std::shared_ptr<const ObjectModel> part, const GripperSpec& gripper,
                         std::vector<GraspCandidate> candidates, const ToleranceOptions& options);

// The error of a try as its hand sees it.
PoseOffset ErrorInG(const ToleranceStudy& study, const ToleranceTry& t);

struct StudyListener {
  std::function<void(int done, int total, int before)> on_progress;
  std::function<bool()> stop;
};
struct StudyOutcomes {
  std::vector<TryOutcome> outcomes;  // by try; short of some when interrupted
  bool interrupted = false;
  std::vector<LostItem> lost;
};
// Executes what FOLDER/tries.csv does not hold yet, over `jobs` processes, and keeps each outcome
// there as it comes; at the end the file is sorted, the same for any number of jobs. Throws
// InputError when the file holds another study, or this one and `resume` is not set.
StudyOutcomes ExecuteStudy(const ToleranceStudy& study, const std::filesystem::path& folder,
                           int jobs, bool resume, const StudyListener& listener);

}  // namespace pickbed
