#include "eval/results_store.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <nlohmann/json.hpp>

#include "eval/results_rows.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr int kSchemaVersion = 4;
constexpr int kBusyTimeoutMs = 60000;  // several workers write to one file

// One prepared statement.
class Statement {
 public:
  Statement(sqlite3* db, const std::string& sql) : db_(db) {
    Check(sqlite3_prepare_v2(db, sql.c_str(), -1, &statement_, nullptr));
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // True when there is a row to read.
  bool Step() {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) Check(code);
    sqlite3_reset(statement_);
    return false;
  }

  void Bind(int column, int value) { Check(sqlite3_bind_int(statement_, column, value)); }
  void Bind(int column, bool value) { Bind(column, static_cast<int>(value)); }
  void Bind(int column, double value) { Check(sqlite3_bind_double(statement_, column, value)); }
  void Bind(int column, const std::string& value) {
    Check(sqlite3_bind_text(statement_, column, value.c_str(), -1, SQLITE_TRANSIENT));
  }
  void Bind(int column, Loss value) { Bind(column, std::string(LossName(value))); }
  void Bind(int column, const Pose& value) {  // row by row, shortest text that reads back the same
    Eigen::Matrix<double, 3, 4, Eigen::RowMajor> rows = value.matrix().topRows<3>();
    Bind(column, nlohmann::json(std::vector<double>(rows.data(), rows.data() + 12)).dump());
  }

  void Read(int column, int& value) const { value = sqlite3_column_int(statement_, column); }
  void Read(int column, bool& value) const { value = sqlite3_column_int(statement_, column) != 0; }
  void Read(int column, double& value) const { value = sqlite3_column_double(statement_, column); }
  void Read(int column, std::string& value) const {
    value = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  }
  void Read(int column, Loss& value) const {
    std::string name;
    Read(column, name);
    value = LossFromName(name).value_or(Loss::kNone);
  }
  void Read(int column, Pose& value) const {
    std::string text;
    Read(column, text);
    const auto numbers = nlohmann::json::parse(text).get<std::vector<double>>();
    value.matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(numbers.data());
  }

 private:
  void Check(int code) const {
    if (code == SQLITE_OK) return;
    const std::string reason = sqlite3_errmsg(db_);
    const bool users = code == SQLITE_FULL || code == SQLITE_READONLY || code == SQLITE_IOERR ||
                       code == SQLITE_CANTOPEN;
    const std::string message = fmt::format("{}: {}", sqlite3_db_filename(db_, "main"), reason);
    if (code == SQLITE_NOTADB || code == SQLITE_CORRUPT) {
      throw InputError(message + "; remove the folder, or choose another with --out");
    }
    if (users) throw InputError(message + "; finished trials are kept, see --resume");
    throw std::runtime_error(message);
  }

  sqlite3* db_;
  sqlite3_stmt* statement_ = nullptr;
};

template <typename Row>
std::string CreateTable(const char* table) {
  std::string columns;
  Row().Visit([&]<typename T>(const char* name, const T&) {
    constexpr bool kInteger = std::is_same_v<T, int> || std::is_same_v<T, bool>;
    const char* type = kInteger ? "INTEGER" : std::is_same_v<T, double> ? "REAL" : "TEXT";
    columns += fmt::format("{}{} {}", columns.empty() ? "" : ", ", name, type);
  });
  return fmt::format("CREATE TABLE IF NOT EXISTS {} ({})", table, columns);
}

template <typename Row>
void Insert(sqlite3* db, const char* table, std::vector<Row> rows) {
  if (rows.empty()) return;
  std::string marks;
  Row().Visit([&](const char*, const auto&) { marks += marks.empty() ? "?" : ", ?"; });
  Statement statement(db, fmt::format("INSERT INTO {} VALUES ({})", table, marks));
  for (Row& row : rows) {
    int column = 0;
    row.Visit([&](const char*, const auto& value) { statement.Bind(++column, value); });
    statement.Step();
  }
}

template <typename Row>
std::vector<Row> Select(sqlite3* db, const char* table) {
  std::string columns;
  Row().Visit([&](const char* name, const auto&) {
    columns += columns.empty() ? name : fmt::format(", {}", name);
  });
  // Rows of a trial were written in order and in one transaction.
  Statement statement(db, fmt::format("SELECT {} FROM {} ORDER BY trial, rowid", columns, table));
  std::vector<Row> rows;
  while (statement.Step()) {
    Row& row = rows.emplace_back();
    int column = 0;
    row.Visit([&](const char*, auto& value) { statement.Read(column++, value); });
  }
  return rows;
}

}  // namespace

struct ResultsStore::Impl {
  ~Impl() { sqlite3_close(db); }
  void Execute(const std::string& sql) { Statement(db, sql).Step(); }

  std::string SettingOr(const char* key, const std::string& fallback) {
    Statement statement(db, "SELECT value FROM settings WHERE key = ?");
    statement.Bind(1, std::string(key));
    std::string value = fallback;
    if (statement.Step()) statement.Read(0, value);
    return value;
  }

  void CreateTables(const std::string& settings) {
    Execute("CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, value TEXT)");
    Execute(CreateTable<TrialRow>("trials"));
    Execute("CREATE UNIQUE INDEX IF NOT EXISTS one_row_a_trial ON trials (trial)");
    Execute(CreateTable<PickRow>("picks"));
    Execute(CreateTable<HypothesisRow>("hypotheses"));
    Execute(CreateTable<InstanceRow>("instances"));
    Execute(CreateTable<FateRow>("fates"));
    Execute(CreateTable<RejectionRow>("rejections"));
    Execute(CreateTable<RefusalRow>("refusals"));
    Execute(CreateTable<TimingRow>("timings"));
    Statement insert(db, "INSERT OR IGNORE INTO settings VALUES (?, ?)");
    insert.Bind(1, std::string("schema_version"));
    insert.Bind(2, std::to_string(kSchemaVersion));
    insert.Step();
    insert.Bind(1, std::string("scenario"));
    insert.Bind(2, settings);
    insert.Step();
    // A run that failed before its first trial ended leaves nothing to be kept apart from.
    Statement update(db,
                     "UPDATE settings SET value = ? WHERE key = 'scenario' "
                     "AND NOT EXISTS (SELECT 1 FROM trials)");
    update.Bind(1, settings);
    update.Step();
  }

  sqlite3* db = nullptr;
};

std::optional<std::string> StoredSettings(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.sqlite";
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  ResultsStore::Impl store;
  const int opened = sqlite3_open_v2(file.c_str(), &store.db, SQLITE_OPEN_READONLY, nullptr);
  CheckInput(opened == SQLITE_OK,
             fmt::format("cannot read {}: {}", file.string(), sqlite3_errmsg(store.db)));
  return store.SettingOr("scenario", "");
}

ResultsStore::ResultsStore(const std::filesystem::path& folder, const std::string& settings)
    : impl_(std::make_unique<Impl>()) {
  const std::string where = folder.string();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckInput(!error, fmt::format("cannot make the folder {}: {}; choose another with --out", where,
                                 error.message()));
  const std::string file = (folder / "results.sqlite").string();
  const int opened = sqlite3_open(file.c_str(), &impl_->db);
  CheckInput(opened == SQLITE_OK,
             fmt::format("cannot write to {}: {}; choose another folder with --out", file,
                         sqlite3_errmsg(impl_->db)));
  sqlite3_busy_timeout(impl_->db, kBusyTimeoutMs);
  // The rollback journal stays: turning a new file to WAL fails when several workers do it at once
  // (no busy timeout covers that), and WAL needs memory that machines of a cluster do not share.
  impl_->Execute("BEGIN IMMEDIATE");
  impl_->CreateTables(settings);
  impl_->Execute("COMMIT");
  const std::string version = impl_->SettingOr("schema_version", "");
  CheckInput(version == std::to_string(kSchemaVersion),
             fmt::format("{} was written by another version of pickbed (schema {}, here {}); "
                         "choose another folder with --out",
                         file, version, kSchemaVersion));
  CheckInput(impl_->SettingOr("scenario", "") == settings,
             fmt::format("{} already holds results of another scenario or of other settings; "
                         "choose another folder with --out or remove this one",
                         where));
}

ResultsStore::~ResultsStore() = default;

void ResultsStore::Write(const TrialResult& result) {
  std::vector<PickRow> picks;
  std::vector<HypothesisRow> hypotheses;
  std::vector<InstanceRow> instances;
  std::vector<FateRow> fates;
  std::vector<RejectionRow> rejections;
  std::vector<RefusalRow> refusals;
  std::vector<TimingRow> timings;
  const int trial = result.trial;
  for (const PickRecord& record : result.picks) {
    picks.push_back({trial, record, record.grasp.has_value(), record.grasp.value_or(Grasp())});
    for (size_t i = 0; i < record.hypotheses.size(); ++i) {
      hypotheses.push_back({trial, record.pick, static_cast<int>(i), record.hypotheses[i]});
    }
    for (const InstanceRecord& instance : record.instances) {
      instances.push_back({trial, record.pick, instance});
    }
    for (const auto& [cause, grasps] : record.grasps_rejected) {
      rejections.push_back({trial, record.pick, cause, grasps});
    }
  }
  for (const InstanceFate& fate : result.fates) fates.push_back({trial, fate});
  for (const RefusedScene& refused : result.refused) {
    for (const std::string& fault : refused.faults) {
      refusals.push_back({trial, refused.attempt, fault});
    }
  }
  for (const auto& [stage, seconds] : result.seconds) timings.push_back({trial, stage, seconds});

  sqlite3* db = impl_->db;
  impl_->Execute("BEGIN IMMEDIATE");
  try {
    Insert<TrialRow>(db, "trials", {{trial, result}});
    Insert(db, "picks", std::move(picks));
    Insert(db, "hypotheses", std::move(hypotheses));
    Insert(db, "instances", std::move(instances));
    Insert(db, "fates", std::move(fates));
    Insert(db, "rejections", std::move(rejections));
    Insert(db, "refusals", std::move(refusals));
    Insert(db, "timings", std::move(timings));
    impl_->Execute("COMMIT");
  } catch (...) {
    sqlite3_exec(db, "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

std::vector<int> ResultsStore::FinishedTrials() const {
  std::vector<int> trials;
  Statement statement(impl_->db, "SELECT trial FROM trials ORDER BY trial");
  while (statement.Step()) statement.Read(0, trials.emplace_back());
  return trials;
}

std::vector<TrialResult> ResultsStore::ReadAll() const {
  sqlite3* db = impl_->db;
  std::vector<TrialResult> results;
  std::map<int, size_t> index;
  for (TrialRow& row : Select<TrialRow>(db, "trials")) {
    index[row.trial] = results.size();
    results.push_back(std::move(row.result));
    results.back().trial = row.trial;
  }
  const auto of = [&](int trial) -> TrialResult& { return results[index.at(trial)]; };
  for (PickRow& row : Select<PickRow>(db, "picks")) {
    if (row.executed) row.record.grasp = row.grasp;
    of(row.trial).picks.push_back(std::move(row.record));
  }
  for (HypothesisRow& row : Select<HypothesisRow>(db, "hypotheses")) {
    of(row.trial).picks[row.pick].hypotheses.push_back(row.score);
  }
  for (InstanceRow& row : Select<InstanceRow>(db, "instances")) {
    of(row.trial).picks[row.pick].instances.push_back(row.record);
  }
  for (const FateRow& row : Select<FateRow>(db, "fates")) of(row.trial).fates.push_back(row.fate);
  for (const RejectionRow& row : Select<RejectionRow>(db, "rejections")) {
    of(row.trial).picks[row.pick].grasps_rejected[row.cause] = row.grasps;
  }
  for (const RefusalRow& row : Select<RefusalRow>(db, "refusals")) {
    std::vector<RefusedScene>& refused = of(row.trial).refused;
    if (refused.empty() || refused.back().attempt != row.attempt) {
      refused.push_back({row.attempt, {}});
    }
    refused.back().faults.push_back(row.fault);
  }
  for (const TimingRow& row : Select<TimingRow>(db, "timings")) {
    of(row.trial).seconds[row.stage] = row.seconds;
  }
  return results;
}

}  // namespace pickbed
