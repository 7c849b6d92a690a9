#pragma once

// Command-line arguments shared by the commands, and the handling of parse errors.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/error.h"
#include "scenes/base/settings_names.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {

struct ReportOptions;

// Adds --json-progress, which every command has. ParseArguments() calls it.
CLI::Option* AddCommonOption(CLI::App& app);

// Hands the description of the command to DescribeCommand() (eval/cli/command_help.h) if that is
// running. Returns whether it is.
bool TakeDescription(CLI::App& app);

// Parses the command line; every command gets --json-progress. Returns true if the command shall
// run, false if help was requested and printed, or only its description is wanted. Throws
// InputError with one line if parsing fails. (The exit codes of CLI11 are over 100, and its
// messages have several lines.)
bool ParseArguments(CLI::App& app, int argc, char** argv);

// Runs a command as a part of another one and prints its command line, `name` and `words`. Returns
// its exit status.
int RunWords(int (*command)(int argc, char** argv), const std::string& name,
             std::vector<std::string> words);

// Adds SCENARIO, --set and --catalog. If not `required`, the scenario is the option --scenario.
void AddScenarioArguments(CLI::App& app, ScenarioRequest& request, bool required = true);
// Returns the error of a run or estimate of a scenario (preset name or file). If it recommends
// `pickbed train OBJECTS` and an object has its own mesh, which only the scenario knows, it
// recommends `pickbed train --scenario FILE` instead.
InputError WithTrainingHint(const InputError& error, const std::string& scenario,
                            const ScenarioSpec& spec);

// Adds --trials: number of bins, instead of the number in the scenario.
void AddTrialsArgument(CLI::App& app, ScenarioRequest& request);
// Adds --jobs and sets the number to the number of processors. `unchanged` names what does not
// depend on it.
CLI::Option* AddJobsArgument(CLI::App& app, int& jobs, const std::string& unchanged = "results do");
// Adds --threads and sets the number to the number of processors.
CLI::Option* AddThreadsArgument(CLI::App& app, int& threads);
// Adds --out; the help shows the default results/<name><suffix>. `name` says in words whose name it
// is.
void AddOutArgument(CLI::App& app, std::string& out, const std::string& suffix = "",
                    const std::string& name = "scenario");
// Returns a check for finite numbers from 0 or above 0. Its message is short; the messages of CLI11
// have the upper limit with all its digits.
CLI::Validator WithoutUpperLimit(bool from_zero = true);

// Adds --programs: the results of others must not start programs unasked, see
// eval/replay/replay.h.
void AddProgramsArgument(CLI::App& app, bool& programs);

// Adds --tolerance: the places of tolerance models, see eval/tolerance/maps.h.
void AddToleranceArgument(CLI::App& app, std::vector<std::string>& places);

// Prints the reason why a page is missing (the result of WritePage, eval/page/html.h), if there is
// one, as one line on stderr. Returns whether the page was written.
bool SayIfUnwritten(const std::string& reason);

// Adds --failure-pictures, see eval/sweep/sweep.h.
void AddFailurePicturesArgument(CLI::App& app, int& trials);

// Adds --failures, --views, --animations and --catalog for a report page.
void AddReportOptions(CLI::App& app, ReportOptions& options, std::string& catalog);

// Adds an earlier name of the option `current` for the same `value`. The help does not show it, and
// each use is reported in one line.
template <typename Value>
CLI::Option* AddFormerName(CLI::App& app, const std::string& former, CLI::Option* current,
                           Value& value) {
  return app.add_option(former, value)
      ->group("")
      ->each([line = "'" + former + "' is deprecated, write '" + current->get_name() +
                     "'"](const std::string&) { ReportDeprecation(line); });
}

// Returns `out`, or results/<name><suffix> if `out` is empty.
std::filesystem::path OutFolder(const std::string& out, const std::string& name,
                                const std::string& suffix = "");

}  // namespace pickbed::eval
