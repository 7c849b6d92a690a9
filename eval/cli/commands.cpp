#include "eval/cli/commands.h"

#include <fmt/format.h>

#include <array>
#include <exception>
#include <set>
#include <string>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/settings_names.h"

namespace pickbed::eval {
namespace {

constexpr int kDone = 0;
constexpr int kBadInput = 1;
constexpr int kOurFault = 2;

constexpr std::array<CommandRow, 21> kCommands{{
    {"run", "drop, look, estimate and pick, trial after trial; measure how often it works",
     RunCommand},
    {"sweep", "run a grid of settings, over processes, shards or a Slurm cluster", SweepCommand},
    {"merge", "join the shards of a sweep, or put several runs side by side", MergeCommand},
    {"budget", "where the picks of a run were lost, and what perfecting a stage would gain",
     BudgetCommand},
    {"replay", "run one trial of a run again, and name the first stage that went another way",
     ReplayCommand},
    {"report", "what a run found, as one HTML page with charts, lost picks and 3D views",
     ReportCommand},
    {"compare", "two runs side by side as one HTML page, with paired differences", CompareCommand},
    {"drop", "fill one bin and show how it came to rest", DropCommand},
    {"render", "fill one bin and write what the camera sees", RenderCommand},
    {"estimate", "guess poses in filled bins and score them against the truth, without picking",
     EstimateCommand},
    {"benchmark", "published methods side by side, on crops of parts", BenchmarkCommand},
    {"train", "learn parts from views rendered on the fly", TrainCommand},
    {"object", "make a part of the catalog from a mesh", ObjectCommand},
    {"sensor", "draw what a depth sensor's profile does", SensorCommand},
    {"grasps", "how a gripper may hold a part: grasps with their qualities, and a picture",
     GraspsCommand},
    {"gripper", "draw a gripper with its frame and sizes", GripperCommand},
    {"dataset", "make a data set in BOP's layout, or check one", DatasetCommand},
    {"score", "score pose estimates on a BOP data set by BOP's rules", ScoreCommand},
    {"tolerance", "how wrong a pose may be and the pick still succeed", ToleranceCommand},
    {"list", "what there is to choose from: objects, estimators, grippers, sensors, ...",
     ListCommand},
    {"doctor", "check that this machine can do all that a run needs", DoctorCommand},
}};

std::string Usage() {
  std::string text =
      "pickbed: drops parts into a bin, looks at them with a depth camera, guesses their poses,\n"
      "picks them in physics, and says how often that works.\n\n"
      "Usage: pickbed COMMAND [OPTIONS]\n\nCommands:\n";
  for (const CommandRow& row : kCommands) text += fmt::format("  {:<10} {}\n", row.name, row.help);
  text +=
      "\n`pickbed COMMAND --help` shows a command's options with an example.\n"
      "A first run: pickbed run demo\n";
  return text;
}

const CommandRow& FindCommand(const std::string& name) {
  std::vector<std::string> names;
  for (const CommandRow& row : kCommands) {
    if (row.name == name) return row;
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("command", name, names));
}

// A file is often read several times, for example once per configuration of a sweep.
void PrintOnce(const std::string& line) {
  static std::set<std::string> printed;
  if (printed.insert(line).second) fmt::print(stderr, "pickbed: {}\n", line);
}

}  // namespace

std::span<const CommandRow> CommandTable() { return kCommands; }

int Dispatch(int argc, char** argv) {
  SetDeprecationListener(PrintOnce);
  try {
    const std::string name = argc > 1 ? argv[1] : "";
    if (name == "--help" || name == "-h" || name == "help") {
      fmt::print("{}", Usage());
      return kDone;
    }
    if (name == "--version") {
      fmt::print("pickbed {}\n", PICKBED_VERSION);
      return kDone;
    }
    CheckInput(!name.empty(), "which command? see pickbed --help");
    return FindCommand(name).run(argc - 1, argv + 1);
  } catch (const InputError& error) {
    fmt::print(stderr, "pickbed: {}\n", error.what());
    return kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "pickbed: internal error: {}\n", error.what());
    return kOurFault;
  }
}

}  // namespace pickbed::eval
