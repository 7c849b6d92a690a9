#pragma once

// Tests given grasps of an object in physics: a single object on a table with the hold test, and in
// bins.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "eval/runtime/process_pool.h"
#include "eval/stats/statistics.h"
#include "grasp/grasp.h"
#include "grasp/gripper.h"
#include "grasp/tolerance/tolerance_trial.h"
#include "scenes/base/settings.h"
#include "scenes/objects/object_model.h"

namespace pickbed::eval {

struct GraspTestOptions {
  int max_grasps = 200;  // tested; of more, an even selection by their order in the file
  int bins = 3;          // filled bins; 0 = only the table
  int instances = 10;    // in each bin
  uint64_t seed = 0;     // of the bins
  RetentionOptions hold{.max_g = 20, .g_per_s = 4};  // hold test on the table
  TableOptions table;
  ExecuteOptions execute;
  void Visit(SettingsVisitor& v);
};

// Result of one grasp.
struct GraspTest {
  int grasp = 0;  // index of the candidate
  // On the table: the most frequent resting pose that leaves the grasp free, -1 = none; then
  // `blocked` is the most frequent cause.
  int place = -1;
  std::string blocked;
  GraspOutcome on_table;
  // In bins: by bin, 1 sample if an instance can be reached, and 1 hit if its pick succeeded.
  std::vector<Cluster> in_bins;
};

// Inputs of the tests. Objects must have convex pieces.
struct GraspTestJob {
  std::shared_ptr<const ObjectModel> object;
  std::shared_ptr<const Gripper> gripper;
  std::vector<GraspCandidate> candidates;
  GraspTestOptions options;
  int jobs = 1;
  std::function<void(const std::string& what, int done, int total)> on_progress;
  std::function<bool()> stop;
};

// Result of TestGrasps(); `tests` is empty if it was stopped.
struct GraspTests {
  std::vector<GraspTest> tests;
  bool interrupted = false;
};

// Executes each grasp on a single object on a table, in the most frequent resting pose that leaves
// it free, as the planner would move it off the table. Then executes it in each bin on the instance
// on which the planner ranks it highest, with true poses. The grasp may be rotated by a symmetry of
// the object. Each execution starts from the same settled scene, so that grasps do not affect each
// other. It forks worker processes; see RunInWorkers for the restrictions. Results do not depend on
// `jobs`. Throws InputError for options out of range.
GraspTests TestGrasps(const GraspTestJob& job);

}  // namespace pickbed::eval
