#pragma once

// Checks of a results store that was damaged, edited or cut short.

#include <filesystem>
#include <string>
#include <vector>

#include "eval/store/schema.h"
#include "eval/store/sqlite.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

inline constexpr int kMaxStoredTrials = 1000000000;  // of a store; trials have 32-bit numbers

// Checks the pages of the file (up to 64 MB), its tables and columns, its configurations and
// trials, ranges of counts and errors, and that the first and last trial of each table exist.
// `db` has the present schema. Throws InputError that names the file, the table and the row.
void CheckTables(const Database& db);

// Checks that the rows of all tables belong together: each attempt to a trial, each hypothesis to
// an attempt, without gaps and doubled rows. It takes longer than reading the store, which finds
// the same faults; it is for rows that are copied unread. Throws as CheckTables().
void CheckRows(const Database& db);

// Checks stage and duration of a row of table `timings`. Throws InputError that says what is wrong,
// without the file.
void CheckTiming(const TimingRow& row);

// Checks values of one trial that other values depend on: indices, shares and counts, and that
// no instance is there twice. Throws InputError that says what is wrong, without the file.
void CheckValues(const TrialResult& result);

// Numbers of entries in the settings of a trial.
struct SettingsCounts {
  size_t objects = 0;
  size_t bands = 0;  // of the visible fraction, in an occlusion sweep
};

// Returns the counts of each configuration of a store in `folder`, by its number. Throws InputError
// that names the store if its settings cannot be read.
std::vector<SettingsCounts> SettingsCountsOf(const StoreHead& head,
                                             const std::filesystem::path& folder);

// Checks that a trial agrees with its settings and with itself: the objects and bands that it names
// exist, each attempt has a grasp or a failure, and as many attempts succeeded as instances were
// cleared. Throws InputError that names `file`.
void CheckTrial(const TrialResult& result, const SettingsCounts& settings, const std::string& file);

}  // namespace pickbed::eval
