#include "eval/cli/arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "eval/report/run_statistics.h"
#include "eval/runtime/progress.h"

namespace pickbed::eval {

namespace {

// CLI11 would show the number of this machine as the default.
CLI::Option* AddProcessors(CLI::App& app, const std::string& name, int& count,
                           const std::string& help) {
  count = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return app.add_option(name, count, help)
      ->check(CLI::Range(1, 1024))
      ->default_str("number of processors");
}

// The limits of CLI11 let NaN pass, because no comparison with it is true.
void RefuseNaN(const CLI::App& app, const std::string& command) {
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_type_name().starts_with("FLOAT")) continue;
    for (const std::string& text : option->results()) {
      CheckInput(
          !std::isnan(std::strtod(text.c_str(), nullptr)),
          fmt::format("{} {}: must be a number; see {} --help", option->get_name(), text, command));
    }
  }
}

// CLI11 only reports that a subcommand is required.
void RequireKnownSubcommand(const CLI::App& app, int argc, char** argv) {
  if (app.get_require_subcommand_min() == 0 || argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* subcommand : app.get_subcommands({}))
    names.push_back(subcommand->get_name());
  CheckInput(std::ranges::find(names, argv[1]) != names.end(),
             UnknownNameMessage("subcommand", argv[1], names));
}

}  // namespace

CLI::Option* AddCommonOption(CLI::App& app) {
  return app.add_flag_callback("--json-progress", WriteProgressAsJson,
                               "progress for programs: one JSON object per line on stderr");
}

void AddProgramsArgument(CLI::App& app, bool& programs) {
  app.add_flag("--programs", programs,
               "start the programs that the stored settings name, such as an estimator in Python; "
               "for results of your own");
}

CLI::Option* AddJobsArgument(CLI::App& app, int& jobs, const std::string& unchanged) {
  return AddProcessors(app, "--jobs", jobs,
                       "number of worker processes; " + unchanged + " not depend on it");
}

CLI::Option* AddThreadsArgument(CLI::App& app, int& threads) {
  return AddProcessors(app, "--threads", threads,
                       "maximum number of threads; results do not depend on it");
}

bool ParseArguments(CLI::App& app, int argc, char** argv) {
  if (TakeDescription(app)) return false;
  AddCommonOption(app);
  for (CLI::App* subcommand : app.get_subcommands({})) subcommand->fallthrough();
  RequireKnownSubcommand(app, argc, argv);
  try {
    app.parse(argc, argv);
    RefuseNaN(app, app.get_name());
    for (const CLI::App* subcommand : app.get_subcommands()) RefuseNaN(*subcommand, app.get_name());
    return true;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      app.exit(error);
      return false;
    }
    std::string reason = error.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    // CLI11 puts the name of the option first, and hidden options have none.
    if (reason.starts_with(": ")) reason.erase(0, 2);
    throw InputError(fmt::format("{}; see {} --help", reason, app.get_name()));
  }
}

void AddScenarioArguments(CLI::App& app, ScenarioRequest& request, bool required) {
  auto* scenario =
      app.add_option(required ? "SCENARIO" : "--scenario", request.scenario,
                     "scenario file, or the name of a preset (see pickbed list presets)");
  if (required) scenario->required();
  app.add_option("--set", request.settings,
                 "change a setting: KEY=VALUE, for example objects.0.count=5; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--catalog", request.catalog, "folder with your own objects")
      ->capture_default_str();
}

InputError WithTrainingHint(const InputError& error, const std::string& scenario,
                            const ScenarioSpec& spec) {
  std::string message = error.what(), names;
  bool has_mesh = false;
  for (const ObjectSpec& object : spec.objects) {
    if (object.distractor) continue;
    names += " " + object.name;
    has_mesh = has_mesh || !object.mesh.empty();
  }
  const size_t place = message.rfind(names + "`");
  if (!has_mesh || message.find("`pickbed train") >= place || place == std::string::npos) {
    return error;
  }
  return InputError(message.replace(place, names.size(), " --scenario " + scenario));
}

void AddTrialsArgument(CLI::App& app, ScenarioRequest& request) {
  app.add_option("--trials", request.trials,
                 "number of bins to fill; replaces the value of the scenario file")
      ->check(CLI::Range(1, 1000000));
}

void AddOutArgument(CLI::App& app, std::string& out, const std::string& suffix,
                    const std::string& name) {
  app.add_option("--out", out, "folder of the results [results/<" + name + ">" + suffix + "]");
}

CLI::Validator WithoutUpperLimit(bool from_zero) {
  const auto fault = [from_zero](std::string& text) {
    char* end = nullptr;
    const double number = std::strtod(text.c_str(), &end);
    const bool is_number = end != text.c_str() && *end == '\0' && std::isfinite(number);
    if (is_number && (from_zero ? number >= 0 : number > 0)) return std::string();
    return fmt::format("'{}' is no number {}", text, from_zero ? "from 0" : "above 0");
  };
  return {fault, from_zero ? "NONNEGATIVE" : "POSITIVE"};
}

void AddToleranceArgument(CLI::App& app, std::vector<std::string>& places) {
  app.add_option("--tolerance", places,
                 "tolerance maps written by `pickbed tolerance` for these objects and this "
                 "gripper: one or several folders, separated by commas; adds to every estimated "
                 "pose the predicted probability that a pick at it succeeds")
      ->delimiter(',');
}

bool SayIfUnwritten(const std::string& reason) {
  if (!reason.empty()) fmt::print(stderr, "pickbed: {}\n", reason);
  return reason.empty();
}

void AddFailurePicturesArgument(CLI::App& app, int& trials) {
  const CLI::Range limits(0, 1000000);
  CLI::Option* current =
      app.add_option(
             "--failure-pictures", trials,
             "number of bins for which every failed pick gets a small picture for the report")
          ->check(limits)
          ->capture_default_str();
  static constexpr const char* kFormer = "--lost-pictures";
  AddFormerName(app, kFormer, current, trials)->check([limits](const std::string& text) {
    const std::string fault = limits(text);
    return fault.empty() ? fault : fmt::format("{}: {}", kFormer, fault);
  });
}

void AddReportOptions(CLI::App& app, ReportOptions& options, std::string& catalog) {
  app.add_option("--failures", options.failures,
                 "maximum number of failed picks shown in the gallery")
      ->check(CLI::Range(0, 5000))
      ->capture_default_str();
  app.add_option("--views", options.views, "maximum number of picks shown in 3D")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--animations", options.animations, "maximum number of animated picks")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--tolerance", options.tolerance,
                 "tolerance maps that forecast the pick success of every configuration: a folder "
                 "of folders written by `pickbed tolerance`, such as results")
      ->delimiter(',');
  app.add_option("--catalog", catalog, "folder with your own objects")->capture_default_str();
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
