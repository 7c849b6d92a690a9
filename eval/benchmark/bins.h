#pragma once

// Benchmark of all bin pose estimators on the same bins, one scenario after another. The results of
// each scenario are stored in a file. A stopped benchmark therefore continues where it stopped, and
// the page is computed only from these files.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/estimate/estimator_comparison.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"
#include "eval/stats/statistics.h"

namespace pickbed::eval {

inline constexpr char kBinsFile[] = "bins.csv";
inline constexpr char kBinsPage[] = "bins.html";

// One estimator configuration, a row of the table.
struct BinMethod {
  const char* label;
  const char* estimator;
  const char* mode;
  // Name of its model, see FindBinModel. "" = it needs none, or has one model for all objects.
  const char* model;
  // Training arguments if no model exists: words after `pickbed train` and before the objects.
  std::vector<std::string> training;
  // Additional words for --small. All models then train in minutes, but they are less accurate.
  std::vector<std::string> small_training = {};
};
// Returns all rows of the benchmark, in the order of its table.
const std::vector<BinMethod>& BinMethods();

// Result of one estimator in one bin.
struct BinStatistics {
  int trial = 0;
  bool top_right = false;  // the highest-ranked pose is correct
  double seconds = 0;      // duration of the estimate
  std::vector<Cluster>
      bands;  // (recalled, instances) per visible-fraction band, EmptyRecallBands()
};

// Results of one estimator in the bins of one scenario.
struct BinRow {
  std::string label;
  std::vector<BinStatistics> bins;
  double ap = 0, ar = 0;  // BOP24 AP and BOP19 AR over the scenario
  double memory_mib = 0;  // peak
  double setup_s = 0;     // time to load the estimator
};

struct BinScenario {
  std::string name;
  std::vector<BinRow> rows;
};

// Converts the row of a comparison to a row of the bin table.
BinRow BinRowOf(const ComparedRow& row);

// Write and read the results of a scenario as JSON. `key` identifies everything that the rows
// depend on. Reading returns nullopt if the file is absent or damaged, or has another key; the
// scenario must then be run again.
void WriteBinScenario(const std::filesystem::path& file, const BinScenario& scenario,
                      const std::string& key);
// Reads the results of a scenario; see above.
std::optional<BinScenario> ReadBinScenario(const std::filesystem::path& file,
                                           const std::string& key);

// Distributes `all` bins evenly over `scenarios`. The first scenarios get the remainder. Returns
// the number of bins per scenario, at least 1.
std::vector<int> SharedBins(int all, int scenarios);

// Returns folder/MODEL-KEY.net, the file into which a method is trained. KEY is a hash of the
// training arguments and the objects, so a file is never confused with another one or overwritten.
std::filesystem::path TrainedModelFile(const BinMethod& method, const std::filesystem::path& folder,
                                       const ObjectSet& objects, bool small);

// Returns the arguments of `pickbed train` that create `file`.
std::vector<std::string> TrainingWords(const BinMethod& method, const std::filesystem::path& file,
                                       const ObjectSet& objects, bool small);

// Returns whether an interrupted training of this file can be resumed.
bool IsBegun(const std::filesystem::path& file);

// Returns the first model file of a method that was trained for these objects, in this order: the
// user's file folder/MODEL.net, TrainedModelFile(), the shipped file. Empty if there is none.
std::filesystem::path FindBinModel(const BinMethod& method, const std::filesystem::path& folder,
                                   const ObjectSet& objects, bool small);

// Returns a CSV table: one line per estimator over all scenarios, then one per scenario and
// estimator.
std::string BinTableCsv(const std::vector<BinScenario>& scenarios);
// Returns the columns of BinTableCsv().
ResultColumns BinTableColumns();
// Returns the statistics over all scenarios as text for the console. `note` is a remark on how the
// numbers were obtained; may be empty.
std::string BinTableText(const std::vector<BinScenario>& scenarios, const std::string& note = "");
// Returns the same statistics as an HTML page.
HtmlPage BinTablePage(const std::vector<BinScenario>& scenarios, const std::string& note = "");

}  // namespace pickbed::eval
