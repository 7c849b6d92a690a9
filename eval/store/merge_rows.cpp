#include "eval/store/merge_rows.h"

#include <fmt/ranges.h>

#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

// Columns of a row in the attached store, with the offsets added.
template <typename Row>
std::string ShiftedColumns(const RowShift& shift) {
  std::vector<std::string> columns = ColumnsOf<Row>();
  for (std::string& column : columns) {
    if (column == "trial") column = fmt::format("trial + {} AS trial", shift.trial);
    if (column == "configuration") {
      column = fmt::format("configuration + {} AS configuration", shift.configuration);
    }
  }
  return fmt::format("{}", fmt::join(columns, ", "));
}

// Returns a trial whose rows in `table` differ between the two stores, -1 = none.
template <typename Row>
int Contradicted(const Database& db, const char* table, const RowShift& shift) {
  const std::string here = fmt::format("SELECT {} FROM main.{} WHERE trial IN doubled",
                                       fmt::join(ColumnsOf<Row>(), ", "), table);
  const std::string there = fmt::format("SELECT {} FROM other.{} WHERE trial + {} IN doubled",
                                        ShiftedColumns<Row>(shift), table, shift.trial);
  for (const auto& [a, b] : {std::pair(here, there), std::pair(there, here)}) {
    Statement statement(db, fmt::format("SELECT trial FROM ({} EXCEPT {})", a, b));
    int trial = -1;
    if (!statement.Step()) continue;
    statement.Read(0, trial);
    return trial;
  }
  return -1;
}

}  // namespace

int JoinRows(const Database& db, const std::filesystem::path& file, const RowShift& shift) {
  Statement attach(db, "ATTACH ? AS other");
  attach.Bind(1, file.string());
  attach.Step();
  int doubled = 0;
  {
    Transaction transaction(db);
    db.Execute("CREATE TEMP TABLE doubled (trial INTEGER PRIMARY KEY)");
    db.Execute(
        fmt::format("INSERT INTO doubled SELECT trial + {0} FROM other.trials WHERE trial + "
                    "{0} IN (SELECT trial FROM main.trials)",
                    shift.trial));
    Statement count(db, "SELECT count(*) FROM doubled");
    count.Step();
    count.Read(0, doubled);
    count.Step();
    ForEachTrialTable([&]<typename Row>(const char* table) {
      if (doubled == 0 || std::is_same_v<Row, TimingRow>) return;
      const int trial = Contradicted<Row>(db, table, shift);
      CheckInput(trial < 0,
                 fmt::format("{}: trial {} is in another store with different {}, "
                             "although both have the same settings; merge only one of them",
                             file.string(), trial - shift.trial, table));
    });
    ForEachTrialTable([&]<typename Row>(const char* table) {
      db.Execute(fmt::format(
          "INSERT INTO main.{0} ({1}) SELECT {2} FROM other.{0} WHERE trial + "
          "{3} NOT IN doubled ORDER BY other.{0}.trial, rowid",
          table, fmt::join(ColumnsOf<Row>(), ", "), ShiftedColumns<Row>(shift), shift.trial));
    });
    db.Execute("DROP TABLE doubled");
    transaction.Commit();
  }
  db.Execute("DETACH other");
  return doubled;
}

}  // namespace pickbed::eval
