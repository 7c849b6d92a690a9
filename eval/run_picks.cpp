#include "eval/run_picks.h"

#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/results_store.h"
#include "eval/run.h"
#include "grasp/success_rules.h"
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
  std::vector<JudgedPick> picks;
  CheckInput(store.head().identity == RunIdentity(scenario.spec, scenario.objects),
             fmt::format("{} was made with another model, gripper, sensor or part than there is "
                         "now; repeat the run",
                         folder.string()));
  for (const TrialResult& trial : store.ReadAll()) {
    for (const PickRecord& pick : trial.picks) {
      if (!pick.grasp || pick.aimed < 0) continue;
      const HypothesisScore& chosen = pick.hypotheses[pick.chosen];
      if (chosen.instance < 0 || scenario.objects[chosen.object]->name != object) continue;
      picks.push_back({chosen.X_OtrueObelieved,
                       pick.outcome.verdicts[static_cast<int>(SuccessRule::kRightPart)],
                       trial.trial, chosen.X_WO.inverse() * pick.grasp->X_WG});
    }
  }
  CheckInput(!picks.empty(),
             fmt::format("{}: none of its picks was of {}", folder.string(), object));
  return picks;
}

}  // namespace pickbed
