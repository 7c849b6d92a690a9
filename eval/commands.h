#pragma once

// The commands of the program. A command parses its own arguments, calls one library function and
// writes what came of it. Adding one is one cmd_NAME.cpp and one row in commands.cpp.

#include <span>

namespace pickbed {

// argv[0] is the command's name. Returns the exit status: 0 done, 130 interrupted. Throws
// InputError for bad input.
int RunCommand(int argc, char** argv);
int SweepCommand(int argc, char** argv);
int MergeCommand(int argc, char** argv);
int BudgetCommand(int argc, char** argv);
int ReplayCommand(int argc, char** argv);
int ReportCommand(int argc, char** argv);
int CompareCommand(int argc, char** argv);
int DropCommand(int argc, char** argv);
int RenderCommand(int argc, char** argv);
int EstimateCommand(int argc, char** argv);
int BenchmarkCommand(int argc, char** argv);
int TrainCommand(int argc, char** argv);
int ObjectCommand(int argc, char** argv);
int SensorCommand(int argc, char** argv);
int GraspsCommand(int argc, char** argv);
int ToleranceCommand(int argc, char** argv);
int GripperCommand(int argc, char** argv);
int ListCommand(int argc, char** argv);
int DatasetCommand(int argc, char** argv);
int ScoreCommand(int argc, char** argv);
int DoctorCommand(int argc, char** argv);

struct CommandRow {
  const char* name;
  const char* help;
  int (*run)(int argc, char** argv);
};
std::span<const CommandRow> CommandTable();

// Finds the command and runs it; prints errors as one line on stderr. Returns the exit status: 0
// done, 1 bad input, 2 our fault, 130 interrupted.
int Dispatch(int argc, char** argv);

}  // namespace pickbed
