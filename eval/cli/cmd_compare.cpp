#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/report/report.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

int CompareCommand(int argc, char** argv) {
  CLI::App app(
      "Tells by how much two runs differ on the scenes that both have, figure by figure, with "
      "intervals and p values, and writes both side by side as one HTML page.",
      "pickbed compare");
  std::string run_a, run_b, out = "comparison.html", json, catalog = "objects";
  ReportOptions options;
  app.add_option("RUN_A", run_a, "results folder of a `pickbed run` or `pickbed sweep`")
      ->required();
  app.add_option("RUN_B", run_b, "another; differences are B - A")->required();
  app.add_option("--out", out, "the page")->capture_default_str();
  app.add_option(
      "--json", json,
      "file that gets the differences as JSON: value of each run, difference and its 95 "
      "% interval, p value and test, scenes, those that differ, odds ratio where a scene "
      "gives one outcome, and of rates the scenes needed");
  AddReportOptions(app, options, catalog);
  app.footer(
      "Example: pickbed compare results/descriptor results/ppf --out ppf.html --json ppf.json");
  if (!ParseArguments(app, argc, argv)) return 0;

  ReportRun a = ReadReportRun(run_a), b = ReadReportRun(run_b);
  RequireWritable(out);
  if (!json.empty()) RequireWritable(json);
  const RunComparison comparison =
      CompareRuns(std::move(a), std::move(b), OpenCatalog(catalog), options);
  WriteFileAtomically(out, comparison.page);
  if (!json.empty()) WriteFileAtomically(json, ComparisonJson(comparison.configurations));
  fmt::print("{}comparison in {}\n", ComparisonText(comparison.configurations), out);
  return 0;
}

}  // namespace pickbed::eval
