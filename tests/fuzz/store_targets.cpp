#include <fmt/format.h>

#include <iterator>
#include <sstream>

#include "eval/store/results_store.h"
#include "eval/store/sqlite.h"
#include "eval/sweep/merge_shards.h"
#include "scenes/base/files.h"
#include "tests/eval/stub_sweep.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;
constexpr int kTrials = 2;  // of each store

// A store of the sweep's trials from `first` on.
std::string StoreBytes(int all_trials = kTrials, int first = 0) {
  const TemporaryFolder temporary;
  {
    ResultsStore store(temporary.path(), HeadOf(StubSweep(1, all_trials), temporary.path()));
    for (int number = first; number < first + kTrials; ++number) {
      TrialResult trial = FullTrial(number);
      trial.instances_cleared = 0;  // none of its attempts succeeds, so a merge accepts it
      store.Write(trial);
    }
  }
  return ReadFileBytes(temporary.path() / kStoreFile);
}

void ReadStore(const fs::path& folder) {
  const ResultsStore store = ResultsStore::OpenToRead(folder);
  store.ForEach([](const TrialResult&) {});
  store.Outcomes();
  store.Crashed();
}

// Merges a store into an empty folder, which copies its rows unread.
void MergeInto(const fs::path& store, const fs::path& out) {
  fs::remove_all(out);
  MergeStores({store}, out);
}

// Edits one row of a store: EDIT TABLE COLUMN ROW VALUE, where EDIT is the letter u (update), d
// (delete), c (copy of the row), r (drop of the column) or t (drop of the table), and TABLE, COLUMN
// and ROW are numbers, modulo the number that there are. VALUE is the rest of the line, a value of
// SQL.
void EditStore(const Database& db, const std::string& line) {
  std::istringstream words(line);
  char edit = ' ';
  unsigned table_number = 0, column_number = 0, row_number = 0;
  if (!(words >> edit >> table_number >> column_number >> row_number)) return;
  std::string value;
  std::getline(words, value);
  const auto name_of = [&db](const std::string& query, unsigned number) -> std::string {
    Statement count(db, fmt::format("SELECT count(*) FROM ({})", query));
    count.Step();
    int names = 0;
    count.Read(0, names);
    if (names == 0) return "";
    Statement pick(
        db, fmt::format("{} LIMIT 1 OFFSET {}", query, number % static_cast<unsigned>(names)));
    pick.Step();
    std::string name;
    pick.Read(0, name);
    return name;
  };
  const std::string table =
      name_of("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name", table_number);
  if (table.empty()) return;
  const std::string column =
      name_of(fmt::format("SELECT name FROM pragma_table_info('{}')", table), column_number);
  const std::string row =
      name_of(fmt::format("SELECT CAST(rowid AS TEXT) FROM {} ORDER BY rowid", table), row_number);
  std::string statement;
  switch (edit) {
    case 'u':
      statement = fmt::format("UPDATE {} SET {} = {} WHERE rowid = {}", table, column, value, row);
      break;
    case 'd':
      statement = fmt::format("DELETE FROM {} WHERE rowid = {}", table, row);
      break;
    case 'c':
      statement = fmt::format("INSERT INTO {0} SELECT * FROM {0} WHERE rowid = {1}", table, row);
      break;
    case 'r':
      statement = fmt::format("ALTER TABLE {} DROP COLUMN {}", table, column);
      break;
    case 't':
      statement = fmt::format("DROP TABLE {}", table);
      break;
    default:
      return;
  }
  // A mutated value may be no SQL.
  sqlite3_exec(db.handle(), statement.c_str(), nullptr, nullptr, nullptr);
}

// Writes a store and edits it, see EditStore().
void WriteEditedStore(const fs::path& folder, const std::string& store, const std::string& edits) {
  fs::remove_all(folder);
  MakeFolder(folder);
  WriteFileAtomically(folder / kStoreFile, store);
  const Database db(folder / kStoreFile, Database::Mode::kExisting);
  std::istringstream lines(edits);
  for (std::string line; std::getline(lines, line);) EditStore(db, line);
}

Contents Edits() {
  // A value of each type, and the ends of ranges, for each table and column.
  constexpr const char* kValues[] = {"NULL", "-1",  "1",         "2147483648", "1e300",  "-0.5",
                                     "''",   "'x'", "'[1,0,0]'", "'finished'", "x'00ff'"};
  // Several edits in each, so that most mutations leave some of them valid.
  constexpr int kTables = 12, kColumns = 64, kContents = 120, kEdits = 6;
  Contents contents;
  for (int i = 0; i < kContents; ++i) {
    std::string edits;
    for (int j = 0; j < kEdits; ++j) {
      edits += fmt::format("u {} {} {} {}\n", (i + 5 * j) % kTables, (7 * i + 11 * j) % kColumns,
                           (i + j) % 3, kValues[(3 * i + j) % std::size(kValues)]);
    }
    contents.push_back(edits);
  }
  for (int table = 0; table < kTables; ++table) {
    for (const char edit : {'d', 'c', 'r', 't'}) {
      contents.push_back(fmt::format("{0} {1} {1} 0\nu {2} {1} 1 -1\n", edit, table, table + 1));
    }
  }
  return contents;
}

FuzzTarget StoreSqlTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    static const std::string kStore = StoreBytes();
    WriteEditedStore(folder / "store", kStore, bytes);
    ReadStore(folder / "store");
    MergeInto(folder / "store", folder / "merged");
  };
  return {"store_sql", run, Edits, true, false};
}

FuzzTarget StoreTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    WriteFileAtomically(folder / kStoreFile, bytes);
    ReadStore(folder);
  };
  return {"store", run, [] { return Contents{StoreBytes()}; }};
}

// The results of two shards of a sweep, one of them edited.
FuzzTarget ShardsTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    static const std::string kFirst = StoreBytes(2 * kTrials);
    static const std::string kSecond = StoreBytes(2 * kTrials, kTrials);
    WriteEditedStore(folder / "shard_0", kFirst, "");
    WriteEditedStore(folder / "shard_1", kSecond, bytes);
    fs::remove_all(folder / "merged");
    const MergeReport report =
        MergeStores({folder / "shard_0", folder / "shard_1"}, folder / "merged");
    RequireLaw(report.trials >= kTrials && report.trials + report.missing == 2 * kTrials,
               "each trial of a sweep is merged or missing");
    ReadStore(folder / "merged");
  };
  return {"store_shards", run, Edits, true, false, 10};
}

}  // namespace

std::vector<FuzzTarget> StoreTargets() { return {StoreTarget(), StoreSqlTarget(), ShardsTarget()}; }

}  // namespace pickbed::tests
