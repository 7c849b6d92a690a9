#pragma once

// Files of a results folder: their names, and the files of a finished run or sweep that are
// computed only from its results store.
//
//   OUT/results.sqlite                     all results, see eval/store/results_store.h
//   OUT/summary.json                       one entry per configuration; of a run: the run itself
//   OUT/trials.csv                         one line per trial
//   OUT/attempts.csv                       one line per attempt
//   OUT/instances.csv                      one line per instance in view of each image
//   OUT/instance_outcomes.csv              one line per dropped instance
//   OUT/configurations.csv                 one line per configuration
//   OUT/timings.csv                        seconds by trial and stage, the only file with times
//   OUT/{curve.csv,pictures/occlusion.png} occlusion trials, by band of the visible fraction
//   OUT/{hidden_share.csv,pictures/hidden_share.png} the same, in the bands of a published
//   benchmark

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "eval/summary/run_summary.h"

namespace pickbed::eval {

// File and folder names in a results folder. kStoreFile is in eval/store/results_store.h.
inline constexpr char kSummaryFile[] = "summary.json";
inline constexpr char kTrialsFile[] = "trials.csv";
inline constexpr char kAttemptsFile[] = "attempts.csv";
inline constexpr char kInstancesFile[] = "instances.csv";
inline constexpr char kInstanceOutcomesFile[] = "instance_outcomes.csv";
inline constexpr char kConfigurationsFile[] = "configurations.csv";
inline constexpr char kTimingsFile[] = "timings.csv";
inline constexpr char kCurveFile[] = "curve.csv";
inline constexpr char kHiddenShareFile[] = "hidden_share.csv";
inline constexpr char kPickChancesFile[] = "pick_chances.csv";     // with tolerance models
inline constexpr char kScenarioFile[] = "scenario.yaml";           // settings of a run
inline constexpr char kSweepFile[] = "sweep.yaml";                 // settings of a sweep
inline constexpr char kConfigurationsFolder[] = "configurations";  // settings of each configuration
inline constexpr char kPicturesFolder[] = "pictures";
inline constexpr char kLogsFolder[] = "logs";               // output of programs, see scenes/plugin
inline constexpr char kOcclusionSheet[] = "occlusion.png";  // in kPicturesFolder
inline constexpr char kHiddenShareSheet[] = "hidden_share.png";  // in kPicturesFolder
inline constexpr char kImageFolderFile[] = "image_folder.txt";   // data set of the images of a run
inline constexpr char kShardsFolder[] = "shards";
inline constexpr char kSlurmFolder[] = "slurm";
inline constexpr char kBudgetFolder[] = "budget";
inline constexpr char kReplayFolder[] = "replay";
inline constexpr char kReportFile[] = "report.html";

// Returns the picture folder of a trial: OUT/pictures/trial_0008.
std::filesystem::path PicturesOf(const std::filesystem::path& out, int trial);
// Returns the file name of a picture of an attempt: "attempt_02_overlay.png". `what` is color,
// depth, overlay or after.
std::string AttemptPicture(int attempt, std::string_view what);
// Returns the file name of the small picture of a failed attempt: "attempt_02_failed.jpg".
std::string FailurePicture(int attempt);
// Returns the picture of an attempt by its name of now or of an earlier version; an empty path if
// the folder has none. `name` is the result of one of the functions above.
std::filesystem::path FindPicture(const std::filesystem::path& folder, const std::string& name);

// Creates and returns OUT/configurations. Removes the settings files of an earlier version, which
// are in another folder.
std::filesystem::path MakeConfigurationsFolder(const std::filesystem::path& out);

// Summary of one configuration.
struct ConfigurationSummary {
  StoredConfiguration configuration;
  RunSummary summary;
};

// Reads the store, writes the files beside it, removes the tables of earlier versions, and returns
// one summary per configuration. Throws InputError if the store cannot be read or the folder cannot
// be written.
std::vector<ConfigurationSummary> WriteSweepFiles(const std::filesystem::path& out);

// Returns the file name of the settings of a configuration: its number and name, without characters
// that file systems reject.
std::string ConfigurationFileName(int configuration, const std::string& name);

// Returns a text for the console: the summary of a run, or one line per configuration of a sweep.
std::string SweepTable(const std::vector<ConfigurationSummary>& configurations);
// Returns the content of summary.json.
std::string SweepJson(const std::vector<ConfigurationSummary>& configurations);

}  // namespace pickbed::eval
