#include "eval/cli/commands.h"

#include <fmt/format.h>

#include <array>
#include <exception>
#include <filesystem>
#include <new>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "eval/cli/benchmark/cmd_benchmark.h"
#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings_names.h"

namespace pickbed::eval {
namespace {

constexpr int kDone = 0;
constexpr int kBadInput = 1;
constexpr int kOurFault = 2;

constexpr auto kCommands = std::to_array<CommandRow>({
    {"run", "drop, capture, estimate and pick in many trials; measure the success rate",
     RunCommand},
    {"report", "write a run as one HTML page with charts, failed picks and 3D views",
     ReportCommand},
    {"compare", "compare two runs on one HTML page, with paired differences", CompareCommand},
    {"sweep", "run a grid of settings in processes, shards or on a Slurm cluster", SweepCommand},
    {"estimate", "estimate poses in filled bins and score them against ground truth",
     EstimateCommand},
    {"doctor", "check that this machine can run pickbed", DoctorCommand},
    {"merge", "merge the shards of a sweep, or put several runs side by side", MergeCommand},
    {"budget", "count failed picks by stage and reason; measure the gain of perfect stages",
     BudgetCommand},
    {"calibrate", "convert the scores of an estimator into probabilities, from a run",
     CalibrateCommand},
    {"replay", "repeat one trial of a run and name the first stage that differs", ReplayCommand},
    {"drop", "fill one bin and write the settled scene", DropCommand},
    {"render", "fill one bin and write the camera image", RenderCommand},
    {"benchmark", "compare published methods on crops of objects and on bins", BenchmarkCommand,
     BenchmarkTables},
    {"train", "train models on views rendered during training", TrainCommand},
    {"object", "add an object to the catalog from a mesh", ObjectCommand},
    {"segment", "divide depth images into unknown objects and score the segments", SegmentCommand},
    {"sensor", "draw the behaviour of a depth sensor profile", SensorCommand},
    {"grasps", "plan grasps of an object with a gripper; write a table and a picture",
     GraspsCommand},
    {"gripper", "draw a gripper with its frame and dimensions", GripperCommand},
    {"dataset", "make a dataset in BOP's layout, or check one", DatasetCommand},
    {"score", "score pose estimates on a BOP dataset with the BOP metrics", ScoreCommand},
    {"execute", "execute the picks that follow from BOP results files, in the scenes they show",
     ExecuteCommand},
    {"plugin", "check an estimator or grasp planner that is a program of yours", PluginCommand},
    {"tolerance", "measure how large a pose error may be before a pick fails", ToleranceCommand},
    {"list", "list the available objects, estimators, grippers, sensors, ...", ListCommand},
    {"completion", "print a script for completion in bash", CompletionCommand},
});

std::string Usage() {
  std::string text =
      "pickbed: drops objects into a bin, captures an RGB-D image, estimates object poses, "
      "executes "
      "grasps\nin physics, and reports how often picking works and which stage fails.\n\nUsage: "
      "pickbed COMMAND [OPTIONS]\n\nFirst commands:\n";
  for (size_t i = 0; i < kCommands.size(); ++i) {
    if (i == kFirstCommands) text += "\nMore commands:\n";
    text += fmt::format("  {:<10} {}\n", kCommands[i].name, kCommands[i].help);
  }
  text +=
      "\n`pickbed COMMAND --help` shows the options of a command with an example.\nFirst run: "
      "pickbed run demo\n";
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

struct RemedyFlag {
  std::string_view remedy, flag;
};
constexpr auto kRemedyFlags = std::to_array<RemedyFlag>({
    {"choose another folder", "--out"},
    {"use fewer workers", "--jobs"},
    {"another results folder", "--out"},
    {"resume it", "--resume"},
    {"resume the run", "--resume"},
    {"put them side by side", "--compare"},
    {"choose a camera", "--camera"},
    {"another image folder", "--bop-out"},
    {"ignored names", "--ignore-names"},
    {"the frame of the file's hand", "--frame"},
    {"the intrinsics of the camera are needed", "--intrinsics"},
    {"give its depth image, too", "--depth"},
});

// Adds the flag behind each remedy, because the libraries do not know the flags.
std::string WithFlags(std::string message) {
  for (const auto& [remedy, flag] : kRemedyFlags) {
    const size_t place = message.find(remedy);
    if (place == std::string::npos) continue;
    message.insert(place + remedy.size(), fmt::format(" ({})", flag));
  }
  return message;
}

}  // namespace

std::span<const CommandRow> CommandTable() { return kCommands; }

int Dispatch(int argc, char** argv) {
  SetDeprecationListener(PrintOnce);
  SetCacheListener(PrintOnce);
  try {
    const std::string name = argc > 1 ? argv[1] : "";
    if (argc <= 1) {
      fmt::print("{}", Usage());
      return kBadInput;
    }
    if (name == "--help" || name == "-h" || name == "help") {
      fmt::print("{}", Usage());
      return kDone;
    }
    if (name == "--version") {
      fmt::print("pickbed {}\n", PICKBED_VERSION);
      return kDone;
    }
    return FindCommand(name).run(argc - 1, argv + 1);
  } catch (const InputError& error) {
    fmt::print(stderr, "pickbed: {}\n", Printable(WithFlags(error.what())));
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    fmt::print(
        stderr,
        "pickbed: cannot use '{}': {}; choose another path, or repeat the command when it can "
        "be reached\n",
        Printable(error.path1().string()), error.code().message());
    return kBadInput;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "pickbed: there is not enough memory; use fewer workers or smaller input\n");
    return kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "pickbed: internal error: {}\n", Printable(error.what()));
    return kOurFault;
  }
}

}  // namespace pickbed::eval
