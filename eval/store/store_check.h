#pragma once

// Checks of a results store that was damaged, edited or cut short.

#include "eval/store/sqlite.h"
#include "eval/trial/trial_records.h"

namespace pickbed::eval {

// Checks the pages of the file, its tables and columns, and that the rows of the tables belong
// together: each attempt to a trial, each hypothesis to an attempt, without gaps. `db` has the
// present schema. Throws InputError that names the file, the table and the row.
void CheckStructure(const Database& db);

// Checks values of one trial that other values depend on: indices, shares and counts. Throws
// InputError that says what is wrong, without the file.
void CheckValues(const TrialResult& result);

}  // namespace pickbed::eval
