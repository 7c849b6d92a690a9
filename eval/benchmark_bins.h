#pragma once

// The bin table: every pose estimator of bins on the same bins, scenario after scenario. What each
// looked at and found is kept in a file a scenario, so that a stopped benchmark goes on where it
// was; the page is made of these files alone.

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/comparison.h"
#include "eval/statistics.h"

namespace pickbed {

// An estimator of the table.
struct BinMethod {
  const char* label;
  const char* estimator;
  const char* mode;
  // Name of its model, see FindBinModel; "" = it needs none or has one for all parts.
  const char* model;
  // How it is trained where there is none: words after `pickbed train` and before the parts.
  std::vector<std::string> training;
  // Further words for a model of --small: minutes for all, and worse.
  std::vector<std::string> small_training = {};
};
const std::vector<BinMethod>& BinMethods();

// What one estimator found in one bin.
struct BinLook {
  int trial = 0;
  bool top_right = false;      // the highest-ranked pose is right
  double seconds = 0;          // of the estimate
  std::vector<Cluster> bands;  // recalled of instances, by visible fraction as EmptyRecallBands()
};

// What one estimator found in the bins of one scenario.
struct BinRow {
  std::string label;
  std::vector<BinLook> looks;
  double ap = 0, ar = 0;  // BOP's, of the scenario
  double memory_mib = 0;  // at most
  double setup_s = 0;     // to load
};

struct BinScenario {
  std::string name;
  std::vector<BinRow> rows;
};

BinRow BinRowOf(const ComparedRow& row);

// `key` names all that the rows depend on. Reading gives nothing for an absent, damaged or foreign
// file: the scenario is then done again.
void WriteBinScenario(const std::filesystem::path& file, const BinScenario& scenario,
                      const std::string& key);
std::optional<BinScenario> ReadBinScenario(const std::filesystem::path& file,
                                           const std::string& key);

// Bins of each of `scenarios`: `all` of them shared out evenly, the first get what is over; at
// least one each.
std::vector<int> SharedBins(int all, int scenarios);

// folder/MODEL-KEY.pt, which a method is trained into: another one for each way to train it and
// each set of parts, so that none is taken for another or written over.
std::filesystem::path TrainedModelFile(const BinMethod& method, const std::filesystem::path& folder,
                                       const ObjectSet& objects, bool small);

// The arguments of `pickbed train` that make that file.
std::vector<std::string> TrainingWords(const BinMethod& method, const std::filesystem::path& file,
                                       const ObjectSet& objects, bool small);

// A training of this file was stopped and left something to go on from.
bool IsBegun(const std::filesystem::path& file);

// The model file of a method that knows these parts: the user's own, folder/MODEL.pt, or that which
// was trained there, or the shipped one; empty where none does.
std::filesystem::path FindBinModel(const BinMethod& method, const std::filesystem::path& folder,
                                   const ObjectSet& objects, bool small);

// A line an estimator and scenario, and one an estimator for all.
std::string BinTableCsv(const std::vector<BinScenario>& scenarios);
// The figures of all scenarios together, for the console. `note`: what the reader must know of how
// they came about; empty = nothing.
std::string BinTableText(const std::vector<BinScenario>& scenarios, const std::string& note = "");
std::string BinTablePage(const std::vector<BinScenario>& scenarios, const std::string& note = "");

}  // namespace pickbed
