#pragma once

// Columns of a CSV file, or keys of a JSON file, with their descriptions. Each writer has one table
// of them. It makes the header line of the file and the generated reference.

#include <span>
#include <string>
#include <vector>

namespace pickbed::eval {

struct ResultColumn {
  // For a JSON key, its path, such as "bands[].recall.rate". A word in capitals, such as REASON,
  // represents names that depend on the results.
  std::string name;
  std::string help;       // meaning, without the unit
  std::string unit = {};  // empty = the unit in the name, see UnitOf()
};
using ResultColumns = std::vector<ResultColumn>;

// Returns the unit of a column or settings key: the given one, or the one at the end of its name,
// such as "mm" for "slip_mm". Empty for a plain number, a name or a text.
std::string UnitOf(const ResultColumn& column);
// Returns the unit at the end of a name; empty if there is none.
std::string UnitInName(const std::string& name);

// Returns the header line of a CSV file: the names, separated by commas, with a line end.
std::string HeaderLine(const ResultColumns& columns);

// Appends columns to a table.
void AddColumns(const ResultColumns& more, ResultColumns& columns);

}  // namespace pickbed::eval
