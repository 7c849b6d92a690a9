#include <fmt/format.h>

#include <filesystem>

#include "eval/calibrate/report.h"
#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/summary/result_files.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::eval {

int CalibrateCommand(int argc, char** argv) {
  CLI::App app(
      "Converts the scores of an estimator into probabilities. Fits P(pose right) and P(pick "
      "succeeds) to the scores of a finished run, and writes a file that estimator.calibration of "
      "a scenario names. Prints the calibration error before and after, cross-validated by bin, "
      "and writes a page with reliability diagrams.",
      "pickbed calibrate");
  std::string run, out;
  int configuration = 0;
  app.add_option("RUN", run, "results folder of a `pickbed run` or `pickbed sweep`")->required();
  auto* number = app.add_option(
      "--configuration", configuration,
      fmt::format("number of the configuration of a sweep (see {})", kConfigurationsFile));
  app.add_option("--out", out, fmt::format("name of the file [RUN/{}]", kCalibrationFile));
  app.footer(
      "Example: pickbed calibrate results/mine\n"
      "         pickbed run bin_ring --set estimator.calibration=results/mine/" +
      std::string(kCalibrationFile));
  if (!ParseArguments(app, argc, argv)) return 0;

  const std::filesystem::path file =
      out.empty() ? std::filesystem::path(run) / kCalibrationFile : std::filesystem::path(out);
  std::filesystem::path page = file;
  page.replace_extension(".html");
  CheckInput(page != file, fmt::format("--out {}: the page gets this name; choose another one that "
                                       "ends in .yaml",
                                       out));
  const CalibrationFit fit = FitCalibration(
      ReadSamples(run, number->count() > 0 ? std::optional(configuration) : std::nullopt));
  WriteFileAtomically(file, WriteCalibration(CalibrationOf(fit)));
  const bool has_page = SayIfUnwritten(WritePage(page, CalibrationReport(fit)));
  fmt::print("{}{}\n", CalibrationText(fit), file.string());
  if (has_page) fmt::print("page: {}\n", page.string());
  return 0;
}

}  // namespace pickbed::eval
