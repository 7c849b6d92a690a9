#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/cli/run_progress.h"
#include "eval/runtime/process.h"
#include "eval/runtime/progress.h"
#include "eval/summary/fill_text.h"
#include "eval/summary/setting_notes.h"
#include "eval/sweep/run.h"

namespace pickbed::eval {
namespace {

RunReport RunWithProgress(const LoadedScenario& scenario, const RunOptions& options) {
  ProgressLine progress;
  return RunScenario(scenario.spec, scenario.objects, options, ShowOn(progress, Interrupted));
}

}  // namespace

int RunCommand(int argc, char** argv) {
  CLI::App app("Runs trials: drops objects into a bin, captures images, estimates poses and picks.",
               "pickbed run");
  ScenarioRequest arguments;
  RunOptions options;
  std::string out;
  std::vector<std::string> tolerance;
  bool json = false;
  AddScenarioArguments(app, arguments);
  AddTrialsArgument(app, arguments);
  AddOutArgument(app, out);
  AddJobsArgument(app, options.jobs);
  app.add_flag("--resume", options.resume, "continue an interrupted run");
  app.add_flag("--retry-crashed", options.retry_crashed,
               "with --resume: repeat the trials whose worker process crashed");
  app.add_option("--pictures", options.picture_trials,
                 "number of trials with pictures of each attempt; 0 = none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  AddFailurePicturesArgument(app, options.failure_picture_trials);
  app.add_option("--bop-out", options.bop_out,
                 "folder for a BOP dataset with every image of the run: one scene per trial, one "
                 "image per attempt, and the scenes for `pickbed execute`");
  AddToleranceArgument(app, tolerance);
  app.add_flag("--json", json, "print the summary as JSON on stdout, and nothing else");
  app.footer("Example: pickbed run demo --trials 10 --set estimator.name=oracle --jobs 2");
  if (!ParseArguments(app, argc, argv)) return 0;

  CatchInterrupts();
  const LoadedScenario scenario = [&] {
    ProgressLine progress;
    return FindScenario(arguments, ShowObjectsOn(progress));
  }();
  options.out = OutFolder(out, scenario.name);
  options.tolerance = MapsFor(scenario.spec, scenario.objects, tolerance);
  fmt::print(stderr, "{}{}", UnfitTools(scenario.spec, scenario.objects),
             UnusedSettings(scenario.spec));
  if (!LoadsEstimator(scenario.spec)) {
    fmt::print(stderr, "{}", SmallObjectNote(scenario.spec, scenario.objects));
  }
  RunReport report;
  try {
    report = RunWithProgress(scenario, options);
  } catch (const InputError& error) {
    throw WithTrainingHint(error, arguments.scenario, scenario.spec);
  }

  if (json) {
    fmt::print("{}", SummaryJson(report.summary));
  } else {
    fmt::print("{}\n{}", FillText(scenario.spec, scenario.objects), SummaryTable(report.summary));
    fmt::print("\nresults in {}\n", options.out.string());
  }
  if (report.interrupted) {
    fmt::print(
        stderr,
        "pickbed: stopped after {} trials; repeat the same command with --resume to continue\n",
        report.summary.trials);
    return kExitInterrupted;
  }
  RequireNoCrash(report.crashed);
  return 0;
}

}  // namespace pickbed::eval
