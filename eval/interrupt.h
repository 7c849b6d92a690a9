#pragma once

// Ctrl-C (SIGINT) and SIGTERM as a flag that long loops look at.

namespace pickbed {

inline constexpr int kExitInterrupted = 130;

// From now on the first signal sets the flag, and a second one ends the process at once.
void CatchInterrupts();
bool Interrupted();

}  // namespace pickbed
