#pragma once

// Copies the rows of one results store into another, in bulk.

#include <filesystem>

#include "eval/store/schema_internal.h"

namespace pickbed::eval {

// Offsets that are added to the numbers of the copied rows.
struct RowShift {
  int trial = 0;
  int configuration = 0;
};

// Copies the trials of `file` that `db` does not hold. `file` must have the current schema version.
// Returns the number of trials that `db` held already. Throws InputError if these differ in
// anything but their times.
int JoinRows(const Database& db, const std::filesystem::path& file, const RowShift& shift);

}  // namespace pickbed::eval
