#pragma once

// C++ layer over SQLite for the results store: statements, transactions, tables defined by row
// structs, and SQLite errors as one clear line each.

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "eval/layer.h"
#include "scenes/base/error.h"
#include "scenes/base/ids.h"
#include "scenes/geometry/pose.h"
#include "scenes/scenario/failure_reason.h"

namespace pickbed::eval {

// An open database file, or a copy of one in memory. Throws InputError for errors that the user can
// repair: a full disk, or a file that is read-only, damaged or no store. Throws std::runtime_error
// for all others.
class Database {
 public:
  enum class Mode { kCreate, kExisting };
  Database(const std::filesystem::path& file, Mode mode);
  ~Database();
  Database(Database&& other) noexcept;
  Database& operator=(Database&&) = delete;

  Database CopyInMemory() const;
  void Execute(const std::string& sql) const;
  // Returns the value of a key in the table `settings`; "" if the table or the key is missing.
  std::string Setting(const std::string& key) const;
  bool HasTable(const std::string& name) const;

  const std::string& file() const { return file_; }
  sqlite3* handle() const { return db_; }

 private:
  Database() = default;
  std::string file_;
  sqlite3* db_ = nullptr;
};

// Throws the error of an SQLite result code. Does nothing for SQLITE_OK.
void CheckSql(const Database& db, int code);

// A transaction from construction to Commit(). The destructor rolls back without a Commit().
class Transaction {
 public:
  explicit Transaction(const Database& db);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void Commit();

 private:
  const Database& db_;
  bool open_ = true;
};

// One prepared statement.
class Statement {
 public:
  Statement(const Database& db, const std::string& sql);
  ~Statement();
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // Executes one step. Returns true if there is a row to read. Otherwise the statement is reset and
  // can be run again.
  bool Step();

  void Bind(int column, int value);
  void Bind(int column, bool value) { Bind(column, static_cast<int>(value)); }
  void Bind(int column, double value);
  void Bind(int column, uint64_t value) { Bind(column, std::to_string(value)); }
  void Bind(int column, const std::string& value);
  void Bind(int column, FailureReason value) { Bind(column, std::string(FailureName(value))); }
  void Bind(int column,
            const Pose& value);  // 3x4, row by row, as text that restores the same value
  void Bind(int column, const std::vector<int>& value);  // as JSON

  // Read a column of the present row. They throw InputError that says what is wrong with the value,
  // but not where it is. A missing value is wrong.
  void Read(int column, int& value) const;
  void Read(int column, bool& value) const;
  void Read(int column, double& value) const;
  void Read(int column, uint64_t& value) const;
  void Read(int column, std::string& value) const;
  void Read(int column, FailureReason& value) const;
  void Read(int column, Pose& value) const;
  void Read(int column, std::vector<int>& value) const;
  bool IsMissing(int column) const;
  template <typename Kind>
  void Read(int column, Id<Kind>& value) const {
    int number = 0;
    Read(column, number);
    value = Id<Kind>(number);
  }

 private:
  std::string Shown(int column) const;
  void Require(bool ok, int column, const char* fault) const;
  template <typename Number>
  std::vector<Number> ReadJson(int column) const;

  const Database& db_;
  sqlite3_stmt* statement_ = nullptr;
};

// Last part of errors about a damaged store.
inline constexpr const char* kRestoreAdvice =
    "restore the file from a copy, or repeat the run in another results folder";

// Throws InputError that names file, table, place ("row 5") and fault of a damaged store.
[[noreturn]] void ThrowDamaged(const Database& db, const std::string& table,
                               const std::string& place, const std::string& fault);

// Calls `read`. Its InputError gets file, table and place as ThrowDamaged() names them.
template <typename Read>
void ReadAt(const Database& db, const std::string& table, const std::string& place, Read read) {
  try {
    read();
  } catch (const InputError& error) {
    ThrowDamaged(db, table, place, error.what());
  }
}

// Returns the names of the columns of a row, in the order of its Visit().
template <typename Row>
std::vector<std::string> ColumnsOf() {
  std::vector<std::string> columns;
  Row().Visit([&](const char* name, const auto&) { columns.push_back(name); });
  return columns;
}

// Creates a missing table, and the columns that a table of an earlier version lacks. Existing rows
// get the value of a default-constructed Row. They get it also for numbers and texts that are NULL,
// for which earlier versions read it.
template <typename Row>
void RequireTable(const Database& db, const std::string& table) {
  std::vector<std::string> present;
  Statement info(db, fmt::format("SELECT name FROM pragma_table_info('{}')", table));
  while (info.Step()) info.Read(0, present.emplace_back());
  std::string all;
  std::map<std::string, std::string> missing;  // column -> type
  Row().Visit([&]<typename T>(const char* name, const T&) {
    constexpr bool kInteger = std::is_same_v<T, int> || std::is_same_v<T, bool> || kIsId<T>;
    const char* type = kInteger ? "INTEGER" : std::is_same_v<T, double> ? "REAL" : "TEXT";
    all += fmt::format("{}{} {}", all.empty() ? "" : ", ", name, type);
    if (std::find(present.begin(), present.end(), name) == present.end()) missing[name] = type;
  });
  if (present.empty()) return db.Execute(fmt::format("CREATE TABLE {} ({})", table, all));
  Row().Visit([&]<typename T>(const char* name, const T& value) {
    constexpr bool kHadDefault = !std::is_same_v<T, int> && !std::is_same_v<T, bool> && !kIsId<T> &&
                                 !std::is_same_v<T, Pose>;
    const bool is_new = missing.contains(name);
    if (!is_new && !kHadDefault) return;
    if (is_new) {
      db.Execute(fmt::format("ALTER TABLE {} ADD COLUMN {} {}", table, name, missing[name]));
    }
    Statement fill(db, fmt::format("UPDATE {0} SET {1} = ? WHERE {1} IS NULL", table, name));
    fill.Bind(1, value);
    fill.Step();
  });
}

// Inserts rows into a table, in their order.
template <typename Row>
void Insert(const Database& db, const char* table, std::vector<Row> rows) {
  if (rows.empty()) return;
  std::string columns, marks;
  for (const std::string& name : ColumnsOf<Row>()) {
    columns += columns.empty() ? name : ", " + name;
    marks += marks.empty() ? "?" : ", ?";
  }
  Statement statement(db, fmt::format("INSERT INTO {} ({}) VALUES ({})", table, columns, marks));
  for (Row& row : rows) {
    int column = 0;
    row.Visit([&](const char*, const auto& value) { statement.Bind(++column, value); });
    statement.Step();
  }
}

// A row that is stored without some of its numbers: SQLite stores NaN as NULL.
template <typename Row>
concept CanLackNumbers = requires(const Row& row) {
  { row.MayLackNumbers() } -> std::same_as<bool>;
};

template <typename Row>
bool MayLackNumbers(const Row& row) {
  if constexpr (CanLackNumbers<Row>) return row.MayLackNumbers();
  return false;
}

// Reads rows in the order of the result. `clause` is the SQL text after the table name. A number
// that a row may lack keeps its default. Throws InputError for a value that is damaged or missing.
template <typename Row, typename Use>
void ForEachRow(const Database& db, const char* table, const std::string& clause, Use use) {
  std::string columns = "rowid";
  for (const std::string& name : ColumnsOf<Row>()) columns += ", " + name;
  Statement statement(db, fmt::format("SELECT {} FROM {} {}", columns, table, clause));
  while (statement.Step()) {
    Row row;
    int column = 0, number = 0;
    const char* at = "";
    try {
      row.Visit([&]<typename T>(const char* name, T& value) {
        at = name;
        ++column;
        if (std::is_same_v<T, double> && statement.IsMissing(column) && MayLackNumbers(row)) return;
        statement.Read(column, value);
      });
    } catch (const InputError& error) {
      statement.Read(0, number);
      ThrowDamaged(db, table, fmt::format("row {}", number),
                   fmt::format("column '{}': {}", at, error.what()));
    }
    use(row);
  }
}

// Same, into a vector.
template <typename Row>
std::vector<Row> Select(const Database& db, const char* table, const std::string& clause) {
  std::vector<Row> rows;
  ForEachRow<Row>(db, table, clause, [&](Row& row) { rows.push_back(std::move(row)); });
  return rows;
}

}  // namespace pickbed::eval
