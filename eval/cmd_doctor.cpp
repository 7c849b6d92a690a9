#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/doctor.h"
#include "scenes/check.h"

namespace pickbed {

int DoctorCommand(int argc, char** argv) {
  CLI::App app(
      "Checks that this machine can render, settle a drop, run a network and store results.",
      "pickbed doctor");
  app.footer("Example: pickbed doctor");
  if (!ParseArguments(app, argc, argv)) return 0;

  int broken = 0;
  for (const Checkup& checkup : ExamineMachine()) {
    fmt::print("{:<7}{:<10}{}\n", checkup.ok ? "ok" : "not ok", checkup.name, checkup.found);
    if (checkup.ok) continue;
    fmt::print("       {}\n", checkup.remedy);
    ++broken;
  }
  CheckInput(broken == 0, fmt::format("{} checks are not ok; see above what to do", broken));
  return 0;
}

}  // namespace pickbed
