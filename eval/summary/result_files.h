#pragma once

// Result files of a finished run or sweep, computed only from its results store.
//
//   OUT/summary.json                        one entry per configuration; of a run: the run itself
//   OUT/{trials,picks,parts,points}.csv     one line per trial, attempt, instance, configuration
//   OUT/timings.csv                         seconds by trial and stage, the only file with times
//   OUT/{curve.csv,pictures/occlusion.png}  occlusion trials, by band of the visible fraction

#include <filesystem>
#include <string>
#include <vector>

#include "eval/summary/run_summary.h"

namespace pickbed::eval {

// Summary of one configuration.
struct ConfigurationSummary {
  StoredConfiguration configuration;
  RunSummary summary;
};

// Reads OUT/results.sqlite, writes the files beside it, and returns one summary per configuration.
// Throws InputError if the store cannot be read or the folder cannot be written.
std::vector<ConfigurationSummary> WriteSweepFiles(const std::filesystem::path& out);

// Returns the file name of the settings of a configuration: its number and name, without characters
// that file systems reject.
std::string ConfigurationFileName(int configuration, const std::string& name);

// Returns a text for the console: the summary of a run, or one line per configuration of a sweep.
std::string SweepTable(const std::vector<ConfigurationSummary>& configurations);
// Returns the content of summary.json.
std::string SweepJson(const std::vector<ConfigurationSummary>& configurations);

}  // namespace pickbed::eval
