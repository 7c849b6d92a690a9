#pragma once

// Commands for unknown objects, which `pickbed train` and `pickbed benchmark` dispatch by their
// first argument. They return the exit status (0 done, 130 interrupted) and throw InputError for
// bad input.

#include "eval/layer.h"

namespace pickbed::eval {

// Runs `pickbed train completion`. Returns the exit status.
int TrainCompletionCommand(int argc, char** argv);
// Runs `pickbed train grasps`. Returns the exit status.
int TrainGraspsCommand(int argc, char** argv);
// Runs `pickbed benchmark completion`. Returns the exit status.
int BenchmarkCompletionCommand(int argc, char** argv);

}  // namespace pickbed::eval
