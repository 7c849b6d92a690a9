#include "eval/store/sqlite.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

constexpr int kBusyTimeoutMs = 60000;  // several workers write to one file

// Throws InputError for a truncated file. SQLite itself reads the end of a cut page as zeros.
void RequireWhole(const Database& db) {
  Statement statement(db, "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size");
  statement.Step();
  double bytes = 0;
  statement.Read(0, bytes);
  CheckInput(std::filesystem::file_size(db.file()) >= bytes,
             fmt::format("{}: is truncated; restore the file from a copy, or repeat the run in "
                         "another results folder",
                         db.file()));
}

}  // namespace

Database::Database(const std::filesystem::path& file, Mode mode) : file_(file.string()) {
  // Always opened for writing. SQLite falls back to read-only access if the file is not writable.
  // After a killed writer, reading needs write access to roll back the unfinished transaction.
  const int flags = SQLITE_OPEN_READWRITE | (mode == Mode::kCreate ? SQLITE_OPEN_CREATE : 0);
  const int opened = sqlite3_open_v2(file_.c_str(), &db_, flags, nullptr);
  if (opened != SQLITE_OK) {
    const std::string reason = sqlite3_errmsg(db_);
    sqlite3_close(std::exchange(db_, nullptr));
    throw InputError(
        mode == Mode::kCreate
            ? fmt::format("cannot write to {}: {}; choose another results folder", file_, reason)
            : fmt::format("cannot read {}: {}", file_, reason));
  }
  sqlite3_busy_timeout(db_, kBusyTimeoutMs);
  RequireWhole(*this);
}

Database::~Database() { sqlite3_close(db_); }

Database::Database(Database&& other) noexcept
    : file_(std::move(other.file_)), db_(std::exchange(other.db_, nullptr)) {}

Database Database::CopyInMemory() const {
  Database copy;
  copy.file_ = file_;
  CheckSql(copy, sqlite3_open(":memory:", &copy.db_));
  sqlite3_backup* backup = sqlite3_backup_init(copy.db_, "main", db_, "main");
  if (backup == nullptr) CheckSql(copy, sqlite3_errcode(copy.db_));
  sqlite3_backup_step(backup, -1);
  CheckSql(copy, sqlite3_backup_finish(backup));
  return copy;
}

void Database::Execute(const std::string& sql) const { Statement(*this, sql).Step(); }

bool Database::HasTable(const std::string& name) const {
  Statement statement(*this, "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?");
  statement.Bind(1, name);
  return statement.Step();
}

std::string Database::Setting(const std::string& key) const {
  if (!HasTable("settings")) return "";
  Statement statement(*this, "SELECT value FROM settings WHERE key = ?");
  statement.Bind(1, key);
  std::string value;
  if (statement.Step()) statement.Read(0, value);
  return value;
}

void CheckSql(const Database& db, int code) {
  if (code == SQLITE_OK) return;
  const std::string message = fmt::format("{}: {}", db.file(), sqlite3_errmsg(db.handle()));
  switch (code & 0xff) {  // without the extended code
    case SQLITE_NOTADB:
    case SQLITE_CORRUPT:
      throw InputError(
          message + "; restore the file from a copy, or repeat the run in another results folder");
    case SQLITE_FULL:
    case SQLITE_IOERR:
      throw InputError(message +
                       "; is the disk full? finished trials are kept: free some space and repeat "
                       "the command, or resume the run or sweep");
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      throw InputError(
          message +
          "; finished trials are kept; make the folder writable, or choose another results folder");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw InputError(message + "; another program has the file open, close it");
    default:
      throw std::runtime_error(message);
  }
}

Transaction::Transaction(const Database& db) : db_(db) { db.Execute("BEGIN IMMEDIATE"); }

Transaction::~Transaction() {
  if (open_) sqlite3_exec(db_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::Commit() {
  db_.Execute("COMMIT");
  open_ = false;
}

Statement::Statement(const Database& db, const std::string& sql) : db_(db) {
  CheckSql(db, sqlite3_prepare_v2(db.handle(), sql.c_str(), -1, &statement_, nullptr));
}

Statement::~Statement() { sqlite3_finalize(statement_); }

bool Statement::Step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) CheckSql(db_, code);
  sqlite3_reset(statement_);
  return false;
}

void Statement::Bind(int column, int value) {
  CheckSql(db_, sqlite3_bind_int(statement_, column, value));
}

void Statement::Bind(int column, double value) {
  CheckSql(db_, sqlite3_bind_double(statement_, column, value));
}

void Statement::Bind(int column, const std::string& value) {
  CheckSql(db_,
           sqlite3_bind_text(statement_, column, value.c_str(), value.size(), SQLITE_TRANSIENT));
}

void Statement::Bind(int column, const Pose& value) {
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = value.matrix().topRows<3>();
  Bind(column, nlohmann::json(std::vector<double>(rows.data(), rows.data() + 12)).dump());
}

void Statement::Bind(int column, const std::vector<int>& value) {
  Bind(column, nlohmann::json(value).dump());
}

void Statement::Read(int column, int& value) const {
  value = sqlite3_column_int(statement_, column);
}

void Statement::Read(int column, bool& value) const {
  value = sqlite3_column_int(statement_, column) != 0;
}

void Statement::Read(int column, double& value) const {
  value = sqlite3_column_double(statement_, column);
}

void Statement::Read(int column, uint64_t& value) const {
  std::string text;
  Read(column, text);
  value = text.empty() ? 0 : std::stoull(text);
}

void Statement::Read(int column, std::string& value) const {
  const unsigned char* text = sqlite3_column_text(statement_, column);
  value = text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

void Statement::Read(int column, FailureReason& value) const {
  std::string name;
  Read(column, name);
  value = FailureFromName(name).value_or(FailureReason::kNone);
}

void Statement::Read(int column, Pose& value) const {
  std::string text;
  Read(column, text);
  const auto numbers = nlohmann::json::parse(text).get<std::vector<double>>();
  value.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data());
}

void Statement::Read(int column, std::vector<int>& value) const {
  std::string text;
  Read(column, text);
  value = text.empty() ? std::vector<int>() : nlohmann::json::parse(text).get<std::vector<int>>();
}

}  // namespace pickbed::eval
