// Measures time, page size and memory of a report of many trials.
//   report_figures [TRIALS] [PAGE.html]     10000 stub trials by default

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

#include "eval/report/report.h"
#include "eval/runtime/process.h"
#include "eval/store/results_store.h"
#include "scenes/base/files.h"
#include "tests/support/stub_trials.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

constexpr const char* kScenario =
    "seed: 17\nobjects: [{name: rod, count: 6}, {name: flange, count: 6}]\n";

template <typename Work>
auto Timed(const char* what, Work work) {
  const auto start = std::chrono::steady_clock::now();
  auto result = work();
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  fmt::print("{:<20}{:8.2f} s   {:6.0f} MB at most so far\n", what, passed.count(),
             1e-6 * PeakMemory());
  return result;
}

void Measure(int trials, const std::filesystem::path& page) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder.path() / "scenario.yaml", kScenario);
  Timed(fmt::format("store {} trials", trials).c_str(), [&] {
    StoreHead head{kScenario,
                   {{.name = "", .trials = trials, .identity = kScenario, .settings = kScenario}}};
    ResultsStore store(folder.path(), head);
    for (int i = 0; i < trials; ++i) store.Write(StubTrial(i));
    return 0;
  });
  ReportRun run = Timed("read", [&] { return ReadReportRun(folder.path()); });
  ReportOptions options;
  options.views = 0;  // stub trials have no scenes
  const std::string html =
      Timed("report", [&] { return RunReportPage(std::move(run), ObjectCatalog({}), options); });
  fmt::print("the page has {:.2f} MB\n", 1e-6 * html.size());
  if (!page.empty()) WriteFileAtomically(page, html);
}

}  // namespace
}  // namespace pickbed::tests

int main(int argc, char** argv) {
  pickbed::tests::Measure(argc > 1 ? std::atoi(argv[1]) : 10000, argc > 2 ? argv[2] : "");
}
