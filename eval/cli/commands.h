#pragma once

// Commands of the program. A command parses its arguments, calls one library function and writes
// its result. A new command needs one cmd_NAME.cpp and one row in commands.cpp.

#include <span>

#include "eval/layer.h"

namespace pickbed::eval {

// argv[0] is the name of the command. Each command returns the exit status: 0 done, 130
// interrupted. It throws InputError for bad input.
int RunCommand(int argc, char** argv);
int SweepCommand(int argc, char** argv);
int MergeCommand(int argc, char** argv);
int BudgetCommand(int argc, char** argv);
int CalibrateCommand(int argc, char** argv);
int ReplayCommand(int argc, char** argv);
int ReportCommand(int argc, char** argv);
int CompareCommand(int argc, char** argv);
int DropCommand(int argc, char** argv);
int RenderCommand(int argc, char** argv);
int EstimateCommand(int argc, char** argv);
int BenchmarkCommand(int argc, char** argv);
int TrainCommand(int argc, char** argv);
int TrainVerifierCommand(int argc, char** argv);  // `pickbed train verifier`
int ObjectCommand(int argc, char** argv);
int SegmentCommand(int argc, char** argv);
int SensorCommand(int argc, char** argv);
int GraspsCommand(int argc, char** argv);
int ToleranceCommand(int argc, char** argv);
int GripperCommand(int argc, char** argv);
int ListCommand(int argc, char** argv);
int DatasetCommand(int argc, char** argv);
int ScoreCommand(int argc, char** argv);
int ExecuteCommand(int argc, char** argv);
int PluginCommand(int argc, char** argv);
int DoctorCommand(int argc, char** argv);
int CompletionCommand(int argc, char** argv);

// A command with its one line of help.
struct CommandRow {
  const char* name;
  const char* help;
  int (*run)(int argc, char** argv);
  // Its own commands, such as `benchmark bins`, if it dispatches them by itself.
  std::span<const CommandRow> (*subcommands)() = nullptr;
};
// Number of commands at the beginning of the table that a first user needs.
inline constexpr int kFirstCommands = 6;
// Returns all commands, in the order of the help.
std::span<const CommandRow> CommandTable();

// Runs the command named by argv[1]; prints an error as one line on stderr. Returns the exit
// status: 0 done, 1 bad input, 2 internal error, 130 interrupted.
int Dispatch(int argc, char** argv);

}  // namespace pickbed::eval
