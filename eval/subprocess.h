#pragma once

// Other programs, run without a shell.

#include <string>
#include <vector>

namespace pickbed {

struct ProgramOutput {
  int status = 0;    // exit status; 127 when the program could not be started
  std::string text;  // stdout and stderr together
};

// Waits for its end.
ProgramOutput RunProgram(const std::vector<std::string>& arguments);

// Whether PATH holds it.
bool HasProgram(const std::string& name);

}  // namespace pickbed
