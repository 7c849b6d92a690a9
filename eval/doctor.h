#pragma once

// Checks that a machine can do all that a run needs.

#include <string>
#include <vector>

namespace pickbed {

struct Checkup {
  std::string name;
  bool ok = false;
  std::string found;   // what was measured, or what went wrong
  std::string remedy;  // what to do when not ok
};

// Renders a known scene, settles a drop, runs a network, writes a result to a temporary folder. A
// check that throws is not ok; none stops the others.
std::vector<Checkup> ExamineMachine();

}  // namespace pickbed
