#include "eval/command_line.h"

#include <fmt/format.h>

#include <algorithm>

#include "eval/progress.h"
#include "eval/report_data.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

// A file as it stands, else a preset of that name.
std::filesystem::path FindScenario(const std::string& scenario) {
  const std::filesystem::path file(scenario);
  if (std::filesystem::exists(file)) {
    CheckInput(!std::filesystem::is_directory(file),
               fmt::format("{} is a folder; name the scenario file in it", scenario));
    return file;
  }
  const std::filesystem::path preset = PresetsDir() / (scenario + ".yaml");
  if (!file.has_parent_path() && std::filesystem::exists(preset)) return preset;
  const std::string message = UnknownNameMessage("scenario", scenario, PresetNames());
  throw InputError(message + " (or the path of a file: there is none of that name)");
}

// A file that lies beside the scenario and not in the current folder.
void FindBeside(const std::filesystem::path& folder, std::string& name_or_path) {
  const std::filesystem::path path(name_or_path);
  if (path.empty() || std::filesystem::exists(path)) return;
  if (std::filesystem::is_regular_file(folder / path)) name_or_path = (folder / path).string();
}

}  // namespace

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

void AddScenarioArguments(CLI::App& app, ScenarioArguments& arguments, bool required) {
  auto* scenario = app.add_option(required ? "SCENARIO" : "--scenario", arguments.scenario,
                                  "scenario file, or the name of a preset (pickbed list presets)");
  if (required) scenario->required();
  app.add_option("--set", arguments.settings,
                 "change a setting, key=value, e.g. objects.0.count=5; may be repeated")
      ->allow_extra_args(false);
  app.add_option("--catalog", arguments.catalog, "folder of your own objects")
      ->capture_default_str();
}

void AddTrialsArgument(CLI::App& app, ScenarioArguments& arguments) {
  app.add_option("--trials", arguments.trials, "bins to fill, instead of the scenario's number")
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

LoadedScenario LoadScenarioArguments(const ScenarioArguments& arguments) {
  const std::filesystem::path file = FindScenario(arguments.scenario);
  std::vector<std::string> settings = arguments.settings;
  if (arguments.trials) settings.push_back(fmt::format("trials={}", *arguments.trials));
  LoadedScenario loaded;
  loaded.name = file.stem().string();
  loaded.spec = LoadScenario(file, settings);
  for (std::string* named :
       {&loaded.spec.sensor, &loaded.spec.gripper, &loaded.spec.estimator.model}) {
    FindBeside(loaded.spec.folder, *named);
  }
  loaded.objects = LoadObjects(loaded.spec, OpenCatalog(arguments.catalog));
  return loaded;
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

void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckInput(!error, fmt::format("cannot make the folder {}: {}; choose another with --out",
                                 folder.string(), error.message()));
}

ObjectCatalog OpenCatalog(const std::string& own_folder) {
  return ObjectCatalog({own_folder, AssetsDir() / "objects"});
}

std::filesystem::path PresetsDir() {
  const std::filesystem::path installed = AssetsDir().parent_path() / "presets";
  if (std::filesystem::exists(installed)) return installed;
  return AssetsDir().parent_path() / "scenes" / "presets";
}

std::vector<std::string> PresetNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(PresetsDir(), error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace pickbed
