#include <fmt/format.h>

#include "eval/command_line.h"
#include "eval/commands.h"
#include "eval/report.h"
#include "scenes/files.h"

namespace pickbed {

int CompareCommand(int argc, char** argv) {
  CLI::App app(
      "Writes two runs side by side as one HTML page, with their paired differences on the scenes "
      "that both have.",
      "pickbed compare");
  std::string run_a, run_b, out = "comparison.html", catalog = "objects";
  ReportOptions options;
  app.add_option("RUN_A", run_a, "results folder of a `pickbed run` or `pickbed sweep`")
      ->required();
  app.add_option("RUN_B", run_b, "another; differences are B - A")->required();
  app.add_option("--out", out, "the page")->capture_default_str();
  AddReportOptions(app, options, catalog);
  app.footer("Example: pickbed compare results/descriptor results/ppf --out ppf.html");
  if (!ParseArguments(app, argc, argv)) return 0;

  ReportRun a = ReadReportRun(run_a), b = ReadReportRun(run_b);
  RequireWritable(out);
  WriteFileAtomically(out,
                      ComparisonPage(std::move(a), std::move(b), OpenCatalog(catalog), options));
  fmt::print("comparison in {}\n", out);
  return 0;
}

}  // namespace pickbed
