#include "eval/run_picks.h"

#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/pick_forecast.h"
#include "eval/results_store.h"
#include "eval/run.h"
#include "scenes/check.h"

namespace pickbed {

std::vector<JudgedPick> PicksOfRun(const std::filesystem::path& folder, const std::string& catalog,
                                   const std::string& object, const std::string& gripper) {
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  ScenarioArguments arguments;
  arguments.scenario = (folder / "scenario.yaml").string();
  arguments.catalog = catalog;
  const LoadedScenario scenario = LoadScenarioArguments(arguments);
  const std::string of_run = LoadGripper(scenario.spec.gripper).name;
  CheckInput(of_run == gripper, fmt::format("{}: picked with gripper {}, the map is of {}",
                                            folder.string(), of_run, gripper));
  CheckInput(store.head().identity == RunIdentity(scenario.spec, scenario.objects),
             fmt::format("{} was made with another model, gripper, sensor or part than there is "
                         "now; repeat the run",
                         folder.string()));
  const std::vector<TrialResult> trials = store.ReadAll();
  std::vector<JudgedPick> picks;
  for (size_t i = 0; i < scenario.objects.size(); ++i) {
    if (scenario.objects[i]->name == object) picks = JudgedPicksOf(trials, static_cast<int>(i));
  }
  CheckInput(!picks.empty(), fmt::format("{}: none of its picks was of a pose that stood on a {}",
                                         folder.string(), object));
  return picks;
}

}  // namespace pickbed
