#include "eval/runtime/tables_progress.h"

#include <fmt/format.h>

namespace pickbed::eval {

ProgressState TablesProgress::State(int done, int total) {
  TableEffort& table = tables_.at(current_);
  table.items = total;
  ProgressState state;
  state.what = table.what;
  state.done = done;
  state.total = total;
  state.note = fmt::format("table {}, {} of {}", table.name, current_ + 1, tables_.size());
  const double pace = expected_s_ > 0 ? taken_s_ / expected_s_ : 1;
  for (size_t i = current_ + 1; i < tables_.size(); ++i) {
    state.later_s += pace * tables_[i].items * tables_[i].item_s;
  }
  return state;
}

void TablesProgress::EndTable(double taken_s) {
  const TableEffort& table = tables_.at(current_++);
  taken_s_ += taken_s;
  expected_s_ += table.items * table.item_s;
}

}  // namespace pickbed::eval
