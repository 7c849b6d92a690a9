#include "eval/sweep/recorded_picks.h"

#include <fmt/format.h>

#include "eval/store/results_store.h"
#include "eval/store/store_check.h"
#include "eval/summary/result_files.h"
#include "eval/sweep/run.h"
#include "eval/tolerance/pick_forecast.h"
#include "grasp/grippers/tools.h"
#include "scenes/base/error.h"
#include "scenes/scenario/find_scenario.h"

namespace pickbed::eval {

std::vector<JudgedPick> PicksOfRun(const std::filesystem::path& folder, const std::string& catalog,
                                   const std::string& object, const std::string& gripper) {
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  ScenarioRequest arguments;
  arguments.scenario = (folder / kScenarioFile).string();
  arguments.catalog = catalog;
  const LoadedScenario scenario = FindScenario(arguments);
  const Tools tools = LoadTools(scenario.spec.gripper.names);
  const std::string of_run = tools.size() == 1 ? tools[0]->name : scenario.spec.gripper.InWords();
  CheckInput(of_run == gripper, fmt::format("{}: picked with gripper {}, but the map is for {}",
                                            folder.string(), of_run, gripper));
  CheckInput(store.head().identity == RunIdentity(scenario.spec, scenario.objects),
             fmt::format("{} was made with another model, gripper, sensor or object than there is "
                         "now; repeat the run",
                         folder.string()));
  const std::vector<TrialResult> trials = store.ReadAll();
  for (const TrialResult& trial : trials) {
    CheckTrial(trial, {scenario.objects.size(), scenario.spec.occlusion.bands.size()},
               (folder / kStoreFile).string());
  }
  std::vector<JudgedPick> picks;
  for (size_t i = 0; i < scenario.objects.size(); ++i) {
    if (scenario.objects[i]->name == object) picks = JudgedPicksOf(trials, ObjectId(i));
  }
  CheckInput(!picks.empty(),
             fmt::format("{}: none of its picks used a pose that matches an instance of {}",
                         folder.string(), object));
  return picks;
}

}  // namespace pickbed::eval
