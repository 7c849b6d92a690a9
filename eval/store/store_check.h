#pragma once

// Checks of a results store that was damaged, edited or cut short.

#include "eval/store/sqlite.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

// Checks the pages of the file (up to 64 MB), its tables and columns, and its configurations and
// trials. `db` has the present schema. Throws InputError that names the file, the table and the
// row.
void CheckTables(const Database& db);

// Checks that the rows of all tables belong together: each attempt to a trial, each hypothesis to
// an attempt, without gaps. It takes longer than reading the store, which finds the same faults; it
// is for rows that are copied unread. Throws as CheckTables().
void CheckRows(const Database& db);

// Checks values of one trial that other values depend on: indices, shares and counts. Throws
// InputError that says what is wrong, without the file.
void CheckValues(const TrialResult& result);

// Checks that the settings of a trial have its objects. Throws InputError that names `file`.
//   objects  number of objects in the settings
void CheckObjects(const TrialResult& result, size_t objects, const std::string& file);

}  // namespace pickbed::eval
