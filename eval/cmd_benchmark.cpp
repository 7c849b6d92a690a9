#include <fmt/format.h>

#include "eval/commands.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

struct Benchmark {
  const char* name;
  const char* help;
  int (*run)(int argc, char** argv);
};

constexpr Benchmark kBenchmarks[] = {
    {"bins", "every pose estimator on filled bins: recall, top-ranked pose, AP, time, memory",
     BenchmarkBinsCommand},
};

}  // namespace

int BenchmarkCommand(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  std::vector<std::string> names;
  std::string usage =
      "Trains what is missing, measures, and makes a table as CSV and page.\n\n"
      "Usage: pickbed benchmark NAME [OPTIONS]\n\n";
  for (const Benchmark& benchmark : kBenchmarks) {
    if (name == benchmark.name) return benchmark.run(argc - 1, argv + 1);
    names.push_back(benchmark.name);
    usage += fmt::format("  {:<8} {}\n", benchmark.name, benchmark.help);
  }
  if (name == "--help" || name == "-h") {
    fmt::print(
        "{}\n`pickbed benchmark NAME --help` shows its options.\n"
        "Example: pickbed benchmark bins --small\n",
        usage);
    return 0;
  }
  CheckInput(!name.empty(), "which benchmark? see pickbed benchmark --help");
  throw InputError(UnknownNameMessage("benchmark", name, names));
}

}  // namespace pickbed
