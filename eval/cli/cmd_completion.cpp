#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "eval/cli/arguments.h"
#include "eval/cli/command_help.h"
#include "eval/cli/commands.h"
#include "eval/trial/oracle_estimator.h"
#include "grasp/grippers/table.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {
namespace {

using Words = std::vector<std::string>;

// Known names by the argument that takes them.
std::map<std::string, Words> NamesByArgument() {
  const Words objects = OpenCatalog("objects").Names();
  Words estimators;
  for (const EstimatorName& row : EstimatorNames()) estimators.push_back(row.name);
  return {{"SCENARIO", PresetNames()},
          {"--scenario", PresetNames()},
          {"OBJECT", objects},
          {"PART", objects},
          {"--objects", objects},
          {"GRIPPER", GripperNames()},
          {"SENSOR", SensorProfileNames()},
          {"--sensor", SensorProfileNames()},
          {"--estimator", estimators}};
}

// Words that can follow a command, and values that can follow its options.
struct CommandWords {
  Words words;
  std::map<std::string, Words> values;  // by option; no values = a file, or any text
};

void AddWords(const CommandHelp& command, const std::map<std::string, Words>& names,
              CommandWords& words) {
  for (const OptionHelp& option : command.options) {
    Words values = option.choices;
    if (const auto known = names.find(option.names); known != names.end()) values = known->second;
    if (option.is_positional) {
      words.words.insert(words.words.end(), values.begin(), values.end());
      continue;
    }
    const std::string first = option.names.substr(0, option.names.find(','));
    words.words.push_back(first);
    if (!option.value.empty()) words.values[first] = values;
  }
  for (const CommandHelp& subcommand : command.subcommands) {
    words.words.push_back(subcommand.name.substr(subcommand.name.rfind(' ') + 1));
    AddWords(subcommand, names, words);
  }
}

}  // namespace

std::string BashCompletion() {
  const std::map<std::string, Words> names = NamesByArgument();
  Words commands;
  std::string by_option, by_command;
  for (const CommandRow& row : CommandTable()) {
    commands.push_back(row.name);
    CommandWords words{{CommonOption().names, "--help"}, {}};
    AddWords(DescribeCommand(row), names, words);
    for (const auto& [option, values] : words.values) {
      by_option +=
          fmt::format("    \"{} {}\") words=\"{}\" ;;\n", row.name, option, fmt::join(values, " "));
    }
    by_command +=
        fmt::format("    \"{} \"*) words=\"{}\" ;;\n", row.name, fmt::join(words.words, " "));
  }
  return fmt::format(
      "# Completion of pickbed for bash: source <(pickbed completion bash)\n"
      "_pickbed() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} words=\n"
      "  if ((COMP_CWORD == 1)); then\n"
      "    COMPREPLY=($(compgen -W \"{}\" -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case \"${{COMP_WORDS[1]}} $before\" in\n"
      "{}{}"
      "  esac\n"
      "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      "}}\n"
      "complete -o default -F _pickbed pickbed\n",
      fmt::join(commands, " "), by_option, by_command);
}

int CompletionCommand(int argc, char** argv) {
  CLI::App app(
      "Prints a script that completes commands, options and names in a shell. It has the names of "
      "the objects in the current folder's catalog.",
      "pickbed completion");
  std::string shell;
  app.add_option("SHELL", shell, "name of the shell")->required()->check(CLI::IsMember({"bash"}));
  app.footer("Example: source <(pickbed completion bash)");
  if (!ParseArguments(app, argc, argv)) return 0;
  fmt::print("{}", BashCompletion());
  return 0;
}

}  // namespace pickbed::eval
