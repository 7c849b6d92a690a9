#include <fmt/format.h>

#include "eval/budget/report.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/page/html.h"
#include "eval/replay/replay.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/result_files.h"
#include "grasp/planners/table.h"

namespace pickbed::eval {
namespace {

BudgetRuns RerunWithProgress(const BudgetJob& job) {
  ProgressLine progress;
  size_t row_index = 0;
  std::string state_text;
  const auto enter = [&](const OracleRow& row) {
    if (row_index > 0 && job.rows[row_index - 1].name == std::string(row.name)) return;
    ++row_index;
    state_text = fmt::format("{} ({}/{})", row.name, row_index, job.rows.size());
    progress.Restart();
  };
  BudgetListener listener;
  listener.on_trial = [&](const OracleRow& row, const RunState& state) {
    enter(row);
    ProgressState shown = ProgressOf(state);
    shown.note = state_text;
    progress.Show(shown);
  };
  listener.on_message = [&](const OracleRow& row, const std::string& line) {
    enter(row);
    progress.Show(fmt::format("{}  {}", state_text, line));
  };
  listener.stop = Interrupted;
  return RerunWithTruth(job, listener);
}

std::vector<OracleRow> RowsNamed(const std::vector<std::string>& names) {
  std::vector<OracleRow> rows;
  if (names.empty()) rows.assign(OracleTable().begin(), OracleTable().end());
  for (const std::string& name : names) {
    if (name != "none") rows.push_back(OracleNamed(name));
  }
  return rows;
}

// Removes the reruns that replace a part of the pose stage, if the planner has none.
void KeepStagesOf(const PlannerRow& planner, std::vector<OracleRow>& rows) {
  if (planner.needs_poses) return;
  std::erase_if(rows, [](const OracleRow& row) {
    const OracleStages& truth = row.truth;
    return !truth.AllOfPerception() && (truth.detection || truth.pose || truth.refinement);
  });
}

std::string StagesHelp() {
  std::string text = "\nStages whose output can be replaced by ground truth:\n";
  for (const OracleRow& row : OracleTable()) {
    text += fmt::format("  {:<12} {}\n", row.name, row.help);
  }
  return text;
}

}  // namespace

int BudgetCommand(int argc, char** argv) {
  CLI::App app(
      "Counts the failed picks of a run by stage and reason. Then repeats its trials with ground "
      "truth in place of one stage at a time, and reports how much more is picked.",
      "pickbed budget");
  std::string run, catalog = "objects";
  std::vector<std::string> stages, tolerance;
  bool json = false, programs = false;
  BudgetJob job;
  app.add_option("RUN", run, "results folder of a `pickbed run`")->required();
  app.add_option(
         "--stages", stages,
         "stages to replace by ground truth, separated by commas; none = no rerun; default: all")
      ->delimiter(',');
  AddJobsArgument(app, job.jobs);
  app.add_option("--catalog", catalog, "folder with your own objects")->capture_default_str();
  AddToleranceArgument(app, tolerance);
  AddProgramsArgument(app, programs);
  app.add_flag("--json", json, "print the budget as JSON on stdout, and nothing else");
  app.footer(StagesHelp() +
             "\nReruns are written to RUN/budget; after an interrupt, the same command "
             "continues.\nExample: pickbed budget results/demo --jobs 2");
  if (!ParseArguments(app, argc, argv)) return 0;

  job.rows = RowsNamed(stages);
  job.run = run;
  const std::filesystem::path scenario = job.run / kScenarioFile;
  CheckInput(
      std::filesystem::is_regular_file(scenario),
      fmt::format("{} has no {}; name the results folder of a `pickbed run`", run, kScenarioFile));
  CatchInterrupts();
  LoadedScenario loaded = FindScenario({scenario.string(), {}, catalog, {}});
  job.spec = std::move(loaded.spec);
  job.objects = std::move(loaded.objects);
  if (!job.rows.empty()) RequireProgramsAllowed(job.spec, run, programs);
  job.tolerance = MapsFor(job.spec, job.objects, tolerance);
  if (stages.empty()) KeepStagesOf(PlannerNamed(job.spec.planner.name), job.rows);
  BudgetRuns runs;
  try {
    runs = RerunWithProgress(job);
  } catch (const InputError& error) {
    throw WithTrainingHint(error, scenario.string(), job.spec);
  }
  if (runs.interrupted) {
    fmt::print(stderr, "pickbed: stopped; repeat the same command to continue\n");
    return kExitInterrupted;
  }
  const std::filesystem::path folder = job.run / kBudgetFolder;
  const bool has_page = SayIfUnwritten(WriteBudget(
      folder, std::filesystem::absolute(job.run / ".").parent_path().filename().string(), runs));
  if (json) {
    fmt::print("{}", BudgetJson(runs));
  } else if (has_page) {
    fmt::print("{}\npage with charts: {}\n", BudgetTable(runs), (folder / kIndexPage).string());
  } else {
    fmt::print("{}\ncharts and tables in {}\n", BudgetTable(runs), folder.string());
  }
  return 0;
}

}  // namespace pickbed::eval
