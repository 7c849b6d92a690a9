#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/page/html.h"
#include "eval/report/report.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

int CompareCommand(int argc, char** argv) {
  CLI::App app(
      "Compares two runs on the scenes that both have: difference of every statistic with interval "
      "and p value. Writes both runs side by side as one HTML page.",
      "pickbed compare");
  std::string run_a, run_b, out = kComparisonPage, json, catalog = "objects";
  ReportOptions options;
  app.add_option("RUN_A", run_a, "results folder of a `pickbed run` or `pickbed sweep`")
      ->required();
  app.add_option("RUN_B", run_b, "results folder of the second run; differences are RUN_B - RUN_A")
      ->required();
  app.add_option("--out", out, "file name of the HTML page")->capture_default_str();
  app.add_option(
      "--json", json,
      "write the differences to this JSON file: value of each run, difference with 95 % interval, "
      "p value and test, number of scenes, scenes with a different outcome, odds ratio if a scene "
      "has one outcome, and the number of scenes needed for rates");
  bool all_rows = false;
  app.add_flag("--all", all_rows,
               "also print the statistics that are equal in every scene; the page has them anyway");
  AddReportOptions(app, options, catalog);
  app.footer(
      "Example: pickbed compare results/descriptor results/ppf --out ppf.html --json ppf.json");
  if (!ParseArguments(app, argc, argv)) return 0;

  ReportRun a = ReadReportRun(run_a), b = ReadReportRun(run_b);
  RequireWritable(out);
  options.page_folder = std::filesystem::absolute(out).parent_path();
  if (!json.empty()) RequireWritable(json);
  const RunComparison comparison =
      CompareRuns(std::move(a), std::move(b), OpenCatalog(catalog), options);
  WriteFileAtomically(out, comparison.page);
  if (!json.empty()) WriteFileAtomically(json, ComparisonJson(comparison.configurations));
  fmt::print("{}comparison in {}\n",
             ComparisonText(comparison.configurations, all_rows, "--all shows them"), out);
  return 0;
}

}  // namespace pickbed::eval
