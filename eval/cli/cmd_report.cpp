#include <fmt/format.h>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/report/report.h"
#include "eval/summary/result_files.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

int ReportCommand(int argc, char** argv) {
  CLI::App app("Writes the statistics of a run or sweep as one HTML page that needs no network.",
               "pickbed report");
  std::string run, out, catalog = "objects";
  ReportOptions options;
  app.add_option("RUN", run, "results folder of a `pickbed run` or `pickbed sweep`")->required();
  app.add_option("--out", out, fmt::format("file name of the HTML page [RUN/{}]", kReportFile));
  AddReportOptions(app, options, catalog);
  app.footer("Example: pickbed report results/demo");
  if (!ParseArguments(app, argc, argv)) return 0;

  ReportRun read = ReadReportRun(run);
  const std::filesystem::path page =
      out.empty() ? std::filesystem::path(run) / kReportFile : std::filesystem::path(out);
  RequireWritable(page);
  options.page_folder = std::filesystem::absolute(page).parent_path();
  WriteFileAtomically(page, RunReportPage(std::move(read), OpenCatalog(catalog), options));
  fmt::print("page: {}\n", page.string());
  return 0;
}

}  // namespace pickbed::eval
