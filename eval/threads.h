#pragma once

// One thread for every library that would start its own pool: workers are processes, and results
// must not depend on how many cores a machine has.

namespace pickbed {

// To be called at the start of the process, before any other work. Sets the environment that
// OpenMP, OpenCV and libtorch read on first use; OpenBLAS has read its own before main() runs and
// is told through its entry point where the process has one.
void UseOneThread();

}  // namespace pickbed
