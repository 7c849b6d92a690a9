#include <fmt/format.h>

#include <string>
#include <vector>

#include "eval/benchmark_commands.h"
#include "eval/commands.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr CommandRow kTables[] = {
    {"crops", "whole-object crops: part and orientation by each method, under each condition",
     &BenchmarkCropsCommand},
    {"bins", "every pose estimator on filled bins: recall, top-ranked pose, AP, time, memory",
     &BenchmarkBinsCommand},
    {"all", "both, one after the other", &BenchmarkAllCommand},
};

std::string Usage() {
  std::string text =
      "Methods side by side, from training to page.\n\nUsage: pickbed benchmark TABLE [OPTIONS]\n\n"
      "Tables:\n";
  for (const CommandRow& row : kTables) text += fmt::format("  {:<8}{}\n", row.name, row.help);
  return text +
         "\n`pickbed benchmark TABLE --help` shows a table's options.\n"
         "Example: pickbed benchmark all --small\n";
}

}  // namespace

int BenchmarkCommand(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  if (name == "--help" || name == "-h") {
    fmt::print("{}", Usage());
    return 0;
  }
  CheckInput(!name.empty(), "which table? see pickbed benchmark --help");
  std::vector<std::string> names;
  for (const CommandRow& row : kTables) {
    if (row.name == name) return row.run(argc - 1, argv + 1);
    names.push_back(row.name);
  }
  throw InputError(UnknownNameMessage("table", name, names));
}

}  // namespace pickbed
