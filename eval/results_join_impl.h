#pragma once

// Copying the rows of one store into another, in bulk.

#include <filesystem>

#include "eval/results_schema_impl.h"

namespace pickbed {

// What is added to numbers of the copied rows.
struct RowShift {
  int trial = 0;
  int point = 0;
};

// Copies the trials of `file` (of this version) that `db` does not hold; returns how many it held
// already. Throws InputError when those are not the same but for their times.
int JoinRows(const Database& db, const std::filesystem::path& file, const RowShift& shift);

}  // namespace pickbed
