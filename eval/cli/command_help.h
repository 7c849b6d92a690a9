#pragma once

// Descriptions of the commands, for the generated reference and for shell completion. They are
// taken from the same definitions as --help.

#include <string>
#include <vector>

#include "eval/cli/commands.h"

namespace pickbed::eval {

// Option or positional argument.
struct OptionHelp {
  std::string names;  // "--jobs", "--distractors, --foreign", or "SCENARIO"
  bool is_positional = false;
  bool required = false;
  std::string value;                 // type and range in words; empty for a flag
  std::vector<std::string> choices;  // allowed values; empty = any
  std::string default_value;         // in words; empty = none
  std::string help;
};

struct CommandHelp {
  std::string name;  // with the program: "pickbed dataset make"
  std::string help;
  std::vector<OptionHelp> options;  // without --help and --json-progress, which all commands have
  std::string footer;               // notes, then "Example: ..."
  std::vector<CommandHelp> subcommands;
};

// Returns the description of a command. The command does not run.
CommandHelp DescribeCommand(const CommandRow& row);

// Returns the option of all commands, besides --help.
OptionHelp CommonOption();

// Returns a script for bash that completes commands, options, and the names of presets, objects,
// grippers, sensors and estimators.
std::string BashCompletion();

}  // namespace pickbed::eval
