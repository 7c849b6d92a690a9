#pragma once

// Progress over several tables that are made one after the other. The time left includes the
// tables that have not begun.

#include <string>
#include <utility>
#include <vector>

#include "eval/runtime/progress.h"

namespace pickbed::eval {

// A table and its expected duration.
struct TableEffort {
  std::string name;
  std::string what;   // kind of its items, such as "bin"
  int items = 0;      // 0 = not known before it begins
  double item_s = 0;  // expected duration of an item on one core, s
};

class TablesProgress {
 public:
  explicit TablesProgress(std::vector<TableEffort> tables) : tables_(std::move(tables)) {}

  // Returns the state of the current table after `done` of `total` items. The tables behind it are
  // expected to take their efforts, times the ratio of taken to expected time so far.
  ProgressState State(int done, int total);
  // Ends the current table, which took `taken_s`.
  void EndTable(double taken_s);

 private:
  std::vector<TableEffort> tables_;
  size_t current_ = 0;
  double taken_s_ = 0, expected_s_ = 0;  // of the tables before the current one
};

}  // namespace pickbed::eval
