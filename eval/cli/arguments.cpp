#include "eval/cli/arguments.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/report/run_statistics.h"
#include "eval/runtime/progress.h"
#include "scenes/base/error.h"

namespace pickbed::eval {

bool ParseArguments(CLI::App& app, int argc, char** argv) {
  app.add_flag_callback("--json-progress", WriteProgressAsJson,
                        "progress for machines: one JSON object a line on stderr");
  for (CLI::App* subcommand : app.get_subcommands({})) subcommand->fallthrough();
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      app.exit(error);
      return false;
    }
    std::string reason = error.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw InputError(fmt::format("{}; see {} --help", reason, app.get_name()));
  }
}

void AddScenarioArguments(CLI::App& app, ScenarioRequest& request, bool required) {
  auto* scenario = app.add_option(required ? "SCENARIO" : "--scenario", request.scenario,
                                  "scenario file, or the name of a preset (pickbed list presets)");
  if (required) scenario->required();
  app.add_option("--set", request.settings,
                 "change a setting, key=value, e.g. objects.0.count=5; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--catalog", request.catalog, "folder of your own objects")->capture_default_str();
}

void AddTrialsArgument(CLI::App& app, ScenarioRequest& request) {
  app.add_option("--trials", request.trials, "bins to fill, instead of the scenario's number")
      ->check(CLI::Range(1, 1000000));
}

void AddOutArgument(CLI::App& app, std::string& out, const std::string& suffix) {
  app.add_option("--out", out, "folder of the results [results/<scenario>" + suffix + "]");
}

void AddToleranceArgument(CLI::App& app, std::vector<std::string>& places) {
  app.add_option(
         "--tolerance", places,
         "maps of `pickbed tolerance` for the parts with this gripper: folders, or a folder "
         "of such, comma-separated; poses get their chance that a pick on them succeeds")
      ->delimiter(',');
}

bool SayIfUnwritten(const std::string& reason) {
  if (!reason.empty()) fmt::print(stderr, "pickbed: {}\n", reason);
  return reason.empty();
}

void AddLostPicturesArgument(CLI::App& app, int& trials) {
  app.add_option("--lost-pictures", trials,
                 "bins of which each lost pick gets a small picture for the report")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
}

void AddReportOptions(CLI::App& app, ReportOptions& options, std::string& catalog) {
  app.add_option("--failures", options.failures, "lost picks in the gallery at most")
      ->check(CLI::Range(0, 5000))
      ->capture_default_str();
  app.add_option("--views", options.views, "picks in 3D at most")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--catalog", catalog, "folder of your own objects")->capture_default_str();
}

int RunWords(int (*command)(int argc, char** argv), const std::string& name,
             std::vector<std::string> words) {
  fmt::print("pickbed {} {}\n", name, fmt::join(words, " "));
  std::fflush(stdout);
  words.insert(words.begin(), name);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  return command(static_cast<int>(argv.size()), argv.data());
}

std::filesystem::path OutFolder(const std::string& out, const std::string& name,
                                const std::string& suffix) {
  return out.empty() ? std::filesystem::path("results") / (name + suffix)
                     : std::filesystem::path(out);
}

}  // namespace pickbed::eval
