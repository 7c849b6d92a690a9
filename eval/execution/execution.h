#pragma once

// Executes BOP results files in the stored scenes of a data set, with several processes.
//
//   OUT/execution.yaml                 scenario, methods and hashes of all inputs
//   OUT/executed_picks.csv             one line per image, method and pick, see pick_rows.h
//   OUT/{execution.json,report.html}   see report.h
//   OUT/lock                           held while a process writes to the folder
//
// All files are identical, byte by byte, for any number of processes and after a resumed call.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "eval/execution/methods.h"
#include "eval/execution/pick_rows.h"
#include "eval/runtime/process_pool.h"
#include "eval/stats/statistics.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::eval {

inline constexpr char kExecutionFile[] = "execution.yaml";
inline constexpr char kExecutionSummaryFile[] = "execution.json";
inline constexpr char kPicksFile[] = "executed_picks.csv";

struct ExecutionOptions {
  std::filesystem::path dataset;  // folder of the data set
  std::string split = "test";
  std::vector<std::filesystem::path> results;  // BOP results files, one per method
  bool oracle = false;                         // also executes the true poses, as the last method
  int picks = 3;                               // maximum number of picks per image and method
  std::filesystem::path out;
  int jobs = 1;
  bool resume = false;
};

struct ExecutionProgress {
  int done = 0, total = 0;        // images
  int done_before = 0;            // done in earlier calls
  std::vector<Cluster> outcomes;  // successes and requested picks of each finished image
};

struct ExecutionListener {
  std::function<void(const ExecutionProgress& progress)> on_image;
  std::function<void(const std::string& line)> on_warning;
  std::function<bool()> stop;
};

struct ExecutionReport {
  std::vector<std::string> methods;  // names, in the order of the files
  std::vector<ExecutedPick> picks;   // by image, method and pick; empty if interrupted
  int images = 0;
  bool interrupted = false;
  std::vector<LostItem> lost;  // images whose process crashed, by their number
};

// Executes the picks of every image of the split. `spec` is the scenario of the data set
// (stored_scenario.yaml) with the gripper, planner and policy to use. Forks, see RunInWorkers.
// Throws InputError for a data set without stored scenes, and for a results file that is broken or
// not of this data set. An output folder is refused in the same way if it holds picks of other
// inputs, or picks while `resume` is not set. Nothing stored is lost then.
ExecutionReport ExecuteResults(const ScenarioSpec& spec, const ObjectSet& objects,
                               const ExecutionOptions& options, const ExecutionListener& listener);

}  // namespace pickbed::eval
