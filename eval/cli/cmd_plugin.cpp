#include <fmt/format.h>

#include <sstream>
#include <string_view>
#include <vector>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/estimate/plugin_check.h"
#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

// Adds the option behind a setting, because other commands set the time limit in the scenario.
std::string WithTimeoutOption(std::string text) {
  constexpr std::string_view kRemedy = "raise timeout_s";
  const size_t place = text.find(kRemedy);
  return place == std::string::npos ? text : text.insert(place + kRemedy.size(), " (--timeout)");
}

std::vector<PluginCheckup> Checkups(const PluginCheckJob& job) {
  try {
    return CheckPlugin(job);
  } catch (const InputError& error) {
    throw InputError(WithTimeoutOption(error.what()));
  }
}

}  // namespace

int PluginCommand(int argc, char** argv) {
  CLI::App app(
      "`plugin check` starts a program of yours that estimates poses or plans grasps, sends it "
      "known images, and checks whether its answers follow the plug-in protocol. It prints what to "
      "correct.",
      "pickbed plugin");
  std::string action, command;
  PluginCheckJob job;
  ScenarioRequest request;
  request.scenario = "bin_rod";
  app.add_option("ACTION", action, "check")->required()->check(CLI::IsMember({"check"}));
  app.add_option("COMMAND", command,
                 "program and its arguments as one text, for example \"python3 my_estimator.py\"");
  app.add_option("--connect", job.address.connect,
                 "address host:port of a running program, instead of COMMAND");
  app.add_option("--role", job.role, "what the program does")
      ->check(CLI::IsMember({kEstimatorRole, kPlannerRole}))
      ->capture_default_str();
  app.add_option("--timeout", job.address.timeout_s,
                 fmt::format("maximum time for each answer, s; the first answer may take {:g} s",
                             job.address.start_timeout_s))
      ->check(CLI::Range(0.01, 86400.0))
      ->capture_default_str();
  app.add_option("--images", job.images, "number of images for the times")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  AddScenarioArguments(app, request, false);
  app.footer(
      "Example: pickbed plugin check \"python3 my_estimator.py\"\n"
      "         pickbed plugin check \"python3 my_planner.py\" --role planner --scenario demo");
  if (!ParseArguments(app, argc, argv)) return 0;

  std::istringstream words(command);
  for (std::string word; words >> word;) job.address.command.push_back(word);
  CheckInput(job.address.command.empty() != job.address.connect.empty(),
             "give either COMMAND or --connect host:port; see pickbed plugin --help");
  job.scenario = FindScenario(request);
  int broken = 0;
  for (const PluginCheckup& checkup : Checkups(job)) {
    fmt::print("{:<7}{:<10}{}\n", checkup.ok ? "ok" : "not ok", checkup.name,
               WithTimeoutOption(checkup.found));
    for (const std::string& line : checkup.remedy) fmt::print("       {}\n", line);
    broken += !checkup.ok;
  }
  CheckInput(broken == 0, fmt::format("{} failed; what to correct is printed below each",
                                      Counted(static_cast<size_t>(broken), "check")));
  return 0;
}

}  // namespace pickbed::eval
