#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/report/report.h"
#include "eval/summary/result_files.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

int ReportCommand(int argc, char** argv) {
  CLI::App app(
      "Writes what a run found as one HTML page that opens from disk and needs no network.",
      "pickbed report");
  std::string run, out, catalog = "objects";
  ReportOptions options;
  app.add_option("RUN", run, "results folder of a `pickbed run` or `pickbed sweep`")->required();
  app.add_option("--out", out, "the page [RUN/report.html]");
  AddReportOptions(app, options, catalog);
  app.footer("Example: pickbed report results/demo");
  if (!ParseArguments(app, argc, argv)) return 0;

  ReportRun read = ReadReportRun(run);
  const std::filesystem::path page =
      out.empty() ? std::filesystem::path(run) / kReportFile : std::filesystem::path(out);
  RequireWritable(page);
  WriteFileAtomically(page, RunReportPage(std::move(read), OpenCatalog(catalog), options));
  fmt::print("report in {}\n", page.string());
  return 0;
}

}  // namespace pickbed::eval
