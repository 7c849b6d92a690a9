#pragma once

// What the results store's files share: statements, tables made from rows, and errors of SQLite as
// one clear line each.

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "scenes/loss.h"
#include "scenes/pose.h"

namespace pickbed {

// An open file, or a copy of one in memory. Throws InputError for what the user can mend (a full
// disk, a file that is read-only, damaged or no store), std::runtime_error for the rest.
class Database {
 public:
  enum class Mode { kCreate, kExisting };
  Database(const std::filesystem::path& file, Mode mode);
  ~Database();
  Database(Database&& other) noexcept;
  Database& operator=(Database&&) = delete;

  Database CopyInMemory() const;
  void Execute(const std::string& sql) const;
  // "" where the table `settings` or the key is missing.
  std::string Setting(const std::string& key) const;
  bool HasTable(const std::string& name) const;

  const std::string& file() const { return file_; }
  sqlite3* handle() const { return db_; }

 private:
  Database() = default;
  std::string file_;
  sqlite3* db_ = nullptr;
};

// Throws what the result code of a call means; nothing for SQLITE_OK.
void CheckSql(const Database& db, int code);

// From BEGIN to COMMIT; rolled back when it is left by an exception.
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

  // True when there is a row to read. Otherwise the statement can be run again.
  bool Step();

  void Bind(int column, int value);
  void Bind(int column, bool value) { Bind(column, static_cast<int>(value)); }
  void Bind(int column, double value);
  void Bind(int column, uint64_t value) { Bind(column, std::to_string(value)); }
  void Bind(int column, const std::string& value);
  void Bind(int column, Loss value) { Bind(column, std::string(LossName(value))); }
  void Bind(int column, const Pose& value);  // row by row, shortest text that reads back the same

  void Read(int column, int& value) const;
  void Read(int column, bool& value) const;
  void Read(int column, double& value) const;
  void Read(int column, uint64_t& value) const;
  void Read(int column, std::string& value) const;
  void Read(int column, Loss& value) const;
  void Read(int column, Pose& value) const;

 private:
  const Database& db_;
  sqlite3_stmt* statement_ = nullptr;
};

template <typename Row>
std::vector<std::string> ColumnsOf() {
  std::vector<std::string> columns;
  Row().Visit([&](const char* name, const auto&) { columns.push_back(name); });
  return columns;
}

// Makes a table that is missing, and columns that a table of an earlier version lacks: rows that
// are there get the value of a row without contents.
template <typename Row>
void RequireTable(const Database& db, const std::string& table) {
  std::vector<std::string> present;
  Statement info(db, fmt::format("SELECT name FROM pragma_table_info('{}')", table));
  while (info.Step()) info.Read(0, present.emplace_back());
  std::string all;
  std::map<std::string, std::string> missing;  // column -> type
  Row().Visit([&]<typename T>(const char* name, const T&) {
    constexpr bool kInteger = std::is_same_v<T, int> || std::is_same_v<T, bool>;
    const char* type = kInteger ? "INTEGER" : std::is_same_v<T, double> ? "REAL" : "TEXT";
    all += fmt::format("{}{} {}", all.empty() ? "" : ", ", name, type);
    if (std::find(present.begin(), present.end(), name) == present.end()) missing[name] = type;
  });
  if (present.empty()) return db.Execute(fmt::format("CREATE TABLE {} ({})", table, all));
  Row().Visit([&](const char* name, const auto& value) {
    if (!missing.contains(name)) return;
    db.Execute(fmt::format("ALTER TABLE {} ADD COLUMN {} {}", table, name, missing[name]));
    Statement fill(db, fmt::format("UPDATE {} SET {} = ?", table, name));
    fill.Bind(1, value);
    fill.Step();
  });
}

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

// `clause` is all that follows the table's name.
template <typename Row>
std::vector<Row> Select(const Database& db, const char* table, const std::string& clause) {
  std::string columns;
  for (const std::string& name : ColumnsOf<Row>()) {
    columns += columns.empty() ? name : ", " + name;
  }
  Statement statement(db, fmt::format("SELECT {} FROM {} {}", columns, table, clause));
  std::vector<Row> rows;
  while (statement.Step()) {
    Row& row = rows.emplace_back();
    int column = 0;
    row.Visit([&](const char*, auto& value) { statement.Read(column++, value); });
  }
  return rows;
}

}  // namespace pickbed
