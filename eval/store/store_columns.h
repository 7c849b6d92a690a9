#pragma once

// Tables of the results store (results.sqlite) with a description of each column.

#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

struct StoreTable {
  std::string name;
  std::string help;
  ResultColumns columns;  // in the order of the table
};

// Returns all tables. Throws std::logic_error if a table or column has no description.
std::vector<StoreTable> StoreTables();

}  // namespace pickbed::eval
