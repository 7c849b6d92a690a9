#pragma once

// Checks whether a program follows the plug-in protocol (scenes/plugin): each rule, repeatability,
// unusual images, errors, the end, and the times of its answers.

#include <string>
#include <vector>

#include "eval/layer.h"
#include "scenes/plugin/plugin_client.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {

// Roles of a plug-in.
inline constexpr char kEstimatorRole[] = "estimator";
inline constexpr char kPlannerRole[] = "planner";

struct PluginCheckJob {
  PluginAddress address;
  std::string role = kEstimatorRole;  // or kPlannerRole
  LoadedScenario scenario;            // the images come from its first bin
  int images = 5;                     // for the times, at least 1
};

// Result of one check.
struct PluginCheckup {
  std::string name;
  bool ok = true;
  std::string found;                // one line
  std::vector<std::string> remedy;  // what to correct, and the program's own report, by line
};

// Runs all checks. A program that fails one is started again for the next. Throws InputError if the
// program does not start or refuses its setup.
std::vector<PluginCheckup> CheckPlugin(const PluginCheckJob& job);

}  // namespace pickbed::eval
