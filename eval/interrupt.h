#pragma once

// Ctrl-C (SIGINT) and SIGTERM: exit status 130, at once or when what is under way has been kept.

namespace pickbed {

inline constexpr int kExitInterrupted = 130;

// From now on a signal ends the process at once, saying so.
void ExitOnInterrupt();

// From now on the first signal sets a flag that long loops look at, and a second one ends the
// process at once.
void CatchInterrupts();
bool Interrupted();

}  // namespace pickbed
