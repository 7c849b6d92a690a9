#pragma once

// Process-level services: signals, thread counts, memory statistics and child programs. SIGINT
// (Ctrl-C) and SIGTERM give exit status 130, at once or after the current results are stored.

#include <cstddef>
#include <string>
#include <vector>

#include "eval/layer.h"

namespace pickbed::eval {

inline constexpr int kExitInterrupted = 130;

// Makes SIGINT and SIGTERM print a message and end the process at once.
void ExitOnInterrupt();

// Makes the first signal set a flag that long loops check with Interrupted(). A second signal ends
// the process at once.
void CatchInterrupts();
// Returns true if the flag is set.
bool Interrupted();

// Limits every library with its own thread pool to one thread. Workers are processes, and results
// must not depend on the number of cores. Call it at the start of the process, before any other
// work. It sets the environment that OpenMP, OpenCV and libtorch read on first use. OpenBLAS reads
// its environment before main(), so its entry point is called if the process has one.
void UseOneThread();

// Memory of this process as counted by the kernel, in bytes of RAM.

// Returns freed memory to the kernel, except up to 64 MiB at the end of the heap of each thread.
// Afterwards new allocations show in the peak, independent of earlier ones.
void ReleaseFreedMemory();
// Resets the peak and returns the memory in use.
size_t ResetPeakMemory();
// Peak since ResetPeakMemory(), or since the start of the process if the kernel cannot reset it.
size_t PeakMemory();

// Other programs, run without a shell.

// Result of a child program.
struct ProgramOutput {
  int status = 0;    // exit status; 127 if the program could not be started, 128 + signal if killed
  std::string text;  // stdout and stderr together
};

// Runs a program from PATH and waits for its end. Throws std::runtime_error if no process can be
// created.
ProgramOutput RunProgram(const std::vector<std::string>& arguments);

// Returns true if PATH contains the program.
bool HasProgram(const std::string& name);

}  // namespace pickbed::eval
