#include "eval/store/sqlite.h"

#include <charconv>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "scenes/base/error.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

constexpr int kBusyTimeoutMs = 60000;  // several workers write to one file

// Throws InputError for a truncated file, or one with a part of a page. SQLite itself reads the end
// of a cut page as zeros, and does not read what follows the last page. A writer may just have
// added pages.
void RequireWhole(const Database& db) {
  Statement statement(db, "SELECT page_count, page_size FROM pragma_page_count, pragma_page_size");
  statement.Step();
  uint64_t pages = 0, page_bytes = 1;
  statement.Read(0, pages);
  statement.Read(1, page_bytes);
  const uint64_t bytes = std::filesystem::file_size(db.file());
  CheckInput(bytes >= pages * page_bytes,
             fmt::format("{}: is truncated; {}", db.file(), kRestoreAdvice));
  CheckInput(bytes % page_bytes == 0, fmt::format("{}: has {} bytes after its last page; {}",
                                                  db.file(), bytes % page_bytes, kRestoreAdvice));
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
  if (!statement.Step()) return value;
  ReadAt(*this, "settings", fmt::format("row '{}'", key), [&] { statement.Read(0, value); });
  return value;
}

void CheckSql(const Database& db, int code) {
  if (code == SQLITE_OK) return;
  const std::string message = fmt::format("{}: {}", db.file(), sqlite3_errmsg(db.handle()));
  std::error_code error;
  CheckInput(db.file().empty() || std::filesystem::exists(db.file(), error),
             fmt::format("{}: the file is gone, because its folder was removed, was renamed or "
                         "cannot be reached; make it available again, and resume the run or sweep",
                         db.file()));
  switch (code & 0xff) {  // without the extended code
    case SQLITE_CORRUPT:  // also if a page could not be read
      throw InputError(fmt::format(
          "{}; repeat the command, since a disk or a shared folder can fail for a moment; if the "
          "fault remains: {}",
          message, kRestoreAdvice));
    case SQLITE_NOTADB:
    case SQLITE_ERROR:       // no such table or column
    case SQLITE_CONSTRAINT:  // a trial twice
    case SQLITE_MISMATCH:
    case SQLITE_TOOBIG:
      throw InputError(fmt::format("{}; {}", message, kRestoreAdvice));
    case SQLITE_IOERR: {
      const int failed = sqlite3_system_errno(db.handle());
      throw InputError(fmt::format(
          "{}{}{}; the disk or the shared folder failed, or the disk is full; finished trials are "
          "kept: repeat the command, or resume the run or sweep",
          message, failed == 0 ? "" : ": ", failed == 0 ? "" : std::strerror(failed)));
    }
    case SQLITE_FULL:
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

// Text of a value for a message: not longer than a line.
std::string Statement::Shown(int column) const {
  const unsigned char* text = sqlite3_column_text(statement_, column);
  return fmt::format(
      "'{}'", Printable(OneLine(text == nullptr ? "NULL" : reinterpret_cast<const char*>(text))));
}

// The message is made only for a fault: this runs for every value of a store.
void Statement::Require(bool ok, int column, const char* fault) const {
  if (!ok) throw InputError(Shown(column) + fault);
}

void Statement::Read(int column, int& value) const {
  const int64_t stored = sqlite3_column_int64(statement_, column);
  value = static_cast<int>(stored);
  Require(sqlite3_column_type(statement_, column) == SQLITE_INTEGER && value == stored, column,
          " is no integer of 32 bits");
}

void Statement::Read(int column, bool& value) const {
  const int64_t stored = sqlite3_column_int64(statement_, column);
  Require(sqlite3_column_type(statement_, column) == SQLITE_INTEGER && (stored == 0 || stored == 1),
          column, " is neither 0 nor 1");
  value = stored != 0;
}

void Statement::Read(int column, double& value) const {
  const int type = sqlite3_column_type(statement_, column);
  Require(type == SQLITE_FLOAT || type == SQLITE_INTEGER, column, " is no number");
  value = sqlite3_column_double(statement_, column);
}

void Statement::Read(int column, uint64_t& value) const {
  std::string text;
  Read(column, text);
  value = 0;
  const char* const end = text.data() + text.size();
  const auto [after, error] = std::from_chars(text.data(), end, value);
  Require(text.empty() || (error == std::errc() && after == end), column,
          " is no unsigned integer of 64 bits");
}

void Statement::Read(int column, std::string& value) const {
  if (sqlite3_column_type(statement_, column) == SQLITE_BLOB) {
    throw InputError("is a BLOB and no text");
  }
  Require(!IsMissing(column), column, " is no text");
  const unsigned char* text = sqlite3_column_text(statement_, column);
  value = text == nullptr ? "" : reinterpret_cast<const char*>(text);
  Require(value.size() == static_cast<size_t>(sqlite3_column_bytes(statement_, column)), column,
          " continues after a zero byte");
  Require(IsUtf8(value), column, " is not UTF-8");
}

bool Statement::IsMissing(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

void Statement::Read(int column, FailureReason& value) const {
  std::string name;
  Read(column, name);
  const std::optional<FailureReason> reason = FailureFromName(name);
  Require(name.empty() || reason, column, " is no failure reason");
  value = reason.value_or(FailureReason::kNone);
}

void Statement::Read(int column, Pose& value) const {
  constexpr double kTolerance = 1e-3;
  const std::vector<double> numbers = ReadJson<double>(column);
  Require(numbers.size() == 12, column, " is no list of 12 numbers");
  value.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data());
  const Eigen::Matrix3d& rotation = value.linear();
  const double deviation =
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  Require(deviation < kTolerance && rotation.determinant() > 0, column,
          " is no pose: its rotation is not orthonormal");
}

void Statement::Read(int column, std::vector<int>& value) const { value = ReadJson<int>(column); }

template <typename Number>
std::vector<Number> Statement::ReadJson(int column) const {
  std::string text;
  Read(column, text);
  if (text.empty()) return {};
  try {
    const auto json = nlohmann::json::parse(text);
    const auto fits = [](const nlohmann::json& item) {
      return std::is_integral_v<Number> ? item.is_number_integer() : item.is_number();
    };
    if (json.is_array() && std::ranges::all_of(json, fits)) return json.get<std::vector<Number>>();
  } catch (const nlohmann::json::exception&) {  // answered below
  }
  throw InputError(Shown(column) + " is no list of numbers");
}

}  // namespace pickbed::eval
