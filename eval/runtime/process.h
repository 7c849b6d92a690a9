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

// Returns freed memory to the kernel, except up to 64 MiB at the end of the heap of each thread.
// Afterwards new allocations show in the peak, independent of earlier ones.
void ReleaseFreedMemory();
// Resets the peak of the process's memory. Returns the memory in use, in bytes of RAM as counted by
// the kernel; 0 if it does not say.
size_t ResetPeakMemory();
// Returns the peak in bytes of RAM since ResetPeakMemory(), or since the start of the process if
// the kernel cannot reset it; 0 if the kernel does not say.
size_t PeakMemory();

// Result of a child program.
struct ProgramOutput {
  int status = 0;    // exit status; 127 if the program could not be started, 128 + signal if killed
  std::string text;  // stdout and stderr together
};

// Runs a program from PATH, without a shell, and waits for its end. `arguments` begins with the
// name of the program. Throws std::runtime_error if no process can be created.
ProgramOutput RunProgram(const std::vector<std::string>& arguments);

// Returns true if PATH contains the program.
bool HasProgram(const std::string& name);

}  // namespace pickbed::eval
