#pragma once

// What the commands share: arguments that name a scenario, and how errors of parsing are told.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scenario_spec.h"

namespace pickbed {

struct ReportOptions;

// Parses; true when the command is to go on, false when help was asked for and printed. Throws
// InputError with one line for anything that cannot be parsed (CLI11's own exit codes are over 100
// and its messages have several lines). Every command takes --json-progress.
bool ParseArguments(CLI::App& app, int argc, char** argv);

// A command that takes part in another one: prints its line, `name` and `words`, and runs it.
int RunWords(int (*command)(int argc, char** argv), const std::string& name,
             std::vector<std::string> words);

struct ScenarioArguments {
  std::string scenario;  // a file, or the name of a preset
  std::vector<std::string> settings;
  std::string catalog = "objects";
  std::optional<int> trials;
};
// SCENARIO, --set, --catalog; SCENARIO may be left out when not `required`.
void AddScenarioArguments(CLI::App& app, ScenarioArguments& arguments, bool required = true);
void AddTrialsArgument(CLI::App& app, ScenarioArguments& arguments);
// --out, default results/<scenario><suffix>, said in the help.
void AddOutArgument(CLI::App& app, std::string& out, const std::string& suffix = "");

// --tolerance: where tolerance models lie, see eval/tolerance_maps.h.
void AddToleranceArgument(CLI::App& app, std::vector<std::string>& places);

// --lost-pictures: see eval/sweep.h.
void AddLostPicturesArgument(CLI::App& app, int& trials);

// --failures, --views and --catalog of a page about runs.
void AddReportOptions(CLI::App& app, ReportOptions& options, std::string& catalog);

struct LoadedScenario {
  std::string name;  // of the file, without folder and ending
  ScenarioSpec spec;
  ObjectSet objects;
};
LoadedScenario LoadScenarioArguments(const ScenarioArguments& arguments);

// results/<name><suffix> when `out` is empty.
std::filesystem::path OutFolder(const std::string& out, const std::string& name,
                                const std::string& suffix = "");
// Throws InputError when it cannot be made.
void MakeFolder(const std::filesystem::path& folder);

// The shipped catalog and, first, the user's own.
ObjectCatalog OpenCatalog(const std::string& own_folder);

// Names of the shipped scenarios, sorted, and where they lie.
std::filesystem::path PresetsDir();
std::vector<std::string> PresetNames();

}  // namespace pickbed
