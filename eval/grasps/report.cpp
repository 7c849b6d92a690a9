#include "eval/grasps/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "eval/stats/roc.h"

namespace pickbed::eval {
namespace {

// Rate of independent grasps.
std::string GraspRateText(int hits, int samples) {
  if (samples == 0) return "-";
  return RateText(static_cast<double>(hits) / samples, WilsonInterval(hits, samples));
}

Cluster TotalOf(const GraspTest& test) { return SumOf(test.in_bins); }

// "3 slipped, 1 collision", the most frequent first.
std::string CountsText(const std::map<std::string, int>& counts) {
  std::vector<std::pair<int, std::string>> sorted;
  for (const auto& [name, count] : counts) sorted.push_back({-count, name});
  std::sort(sorted.begin(), sorted.end());
  std::string text;
  for (const auto& [count, name] : sorted) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", -count, name);
  }
  return text;
}

std::string TableText(const GraspTests& tests) {
  int picked = 0, blocked = 0;
  std::map<std::string, int> failures, causes;
  for (const GraspTest& test : tests.tests) {
    picked += test.on_table.success;
    blocked += test.place < 0;
    if (test.place < 0) ++causes[test.blocked];
    if (test.place >= 0 && !test.on_table.success) {
      ++failures[std::string(FailureName(test.on_table.failure))];
    }
  }
  const int tried = static_cast<int>(tests.tests.size()) - blocked;
  std::string text = fmt::format("on a table         {} of {} succeed, {}\n", picked, tried,
                                 GraspRateText(picked, tried));
  if (!failures.empty()) text += fmt::format("  failed           {}\n", CountsText(failures));
  if (!causes.empty()) text += fmt::format("  not executed     {}\n", CountsText(causes));
  return text;
}

std::string HoldText(const GraspTests& tests, double max_g) {
  std::vector<double> loads;
  for (const GraspTest& test : tests.tests) {
    if (test.on_table.retention_g >= 0) loads.push_back(test.on_table.retention_g);
  }
  if (loads.empty()) return "";
  std::sort(loads.begin(), loads.end());
  const auto to_end =
      std::count_if(loads.begin(), loads.end(), [max_g](double load_g) { return load_g >= max_g; });
  return fmt::format(
      "hold test          {} grasps hold {:.1f} g in the median, {:.1f} g at least; {} reach the "
      "limit of {:g} g\n",
      loads.size(), loads[(loads.size() - 1) / 2], loads.front(), to_end, max_g);
}

std::string BinsText(const GraspTests& tests, const GraspTestOptions& options) {
  if (options.bins == 0) return "";
  std::vector<Cluster> by_bin(options.bins);
  int reached = 0;
  for (const GraspTest& test : tests.tests) {
    for (int bin = 0; bin < options.bins; ++bin) {
      by_bin[bin].hits += test.in_bins[bin].hits;
      by_bin[bin].samples += test.in_bins[bin].samples;
    }
    reached += TotalOf(test).samples > 0;
  }
  const ReportRate rate = ClusterRate(by_bin);
  const std::string where = fmt::format("in {} bins of {}", options.bins, options.instances);
  return fmt::format("{:<19}{} of {} picks succeed, {}; {} of {} grasps reach an instance\n", where,
                     rate.hits, rate.samples, RateText(rate), reached, tests.tests.size());
}

// AUC of the confidences.
std::string ConfidenceText(const GraspFile& file, const GraspTests& tests) {
  std::vector<ScoredOutcome> on_table, in_bins;
  for (const GraspTest& test : tests.tests) {
    const double confidence = file.grasps[test.grasp].confidence;
    if (test.place >= 0) on_table.push_back({confidence, test.on_table.success});
    const Cluster total = TotalOf(test);
    for (int i = 0; i < total.samples; ++i) in_bins.push_back({confidence, i < total.hits});
  }
  std::string text;
  const auto add = [&](const char* where, const std::vector<ScoredOutcome>& outcomes) {
    const AucResult auc = Auc(outcomes);
    if (auc.is_known())
      text += fmt::format("{}{} {:.3f}", text.empty() ? "" : ", ", where, auc.auc);
  };
  add("on the table", on_table);
  add("in bins", in_bins);
  return text.empty() ? "" : fmt::format("AUC of confidence  {}\n", text);
}

}  // namespace

ResultColumns GraspTestsColumns() {
  return {
      {"grasp", "number of the grasp in the file, from 0"},
      {"name", "name of the grasp in the file"},
      {"confidence", "confidence in the file"},
      {"resting_pose", "resting pose on the table, 0 = most frequent; -1 = none leaves it free"},
      {"success", "1 if the grasp succeeded on the table"},
      {"failure", "failure reason on the table, or none"},
      {"blocked", "why no resting pose leaves it free; else empty"},
      {"slip_mm", "movement of the object in the hand on the table"},
      {"retention_g",
       "load at which the hold test lost the object, or its limit; -1 = not measured", "g"},
      {"bins_reached", "number of bins with an instance that the grasp reaches"},
      {"bins_picked", "number of successful picks in them"},
  };
}

std::string GraspTestsCsv(const GraspFile& file, const GraspTests& tests) {
  std::string csv = HeaderLine(GraspTestsColumns());
  for (const GraspTest& test : tests.tests) {
    const FileGrasp& grasp = file.grasps[test.grasp];
    const Cluster total = TotalOf(test);
    csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", test.grasp, CsvCell(grasp.name),
                       grasp.confidence, test.place, test.on_table.success ? 1 : 0,
                       FailureName(test.on_table.failure), test.blocked, 1e3 * test.on_table.slip_m,
                       test.on_table.retention_g, total.samples, total.hits);
  }
  return csv;
}

std::string GraspTestsText(const GraspFile& file, const GraspTests& tests,
                           const GraspTestOptions& options) {
  return fmt::format("{} of {} grasps of {}\n", tests.tests.size(), file.grasps.size(), file.file) +
         TableText(tests) + HoldText(tests, options.hold.max_g) + BinsText(tests, options) +
         ConfidenceText(file, tests);
}

}  // namespace pickbed::eval
