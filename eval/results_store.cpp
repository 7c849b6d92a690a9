#include "eval/results_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "eval/results_schema_impl.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

constexpr char kFileName[] = "results.sqlite";
constexpr int kTrialsAtATime = 256;  // that ForEach holds

std::filesystem::path FileIn(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckInput(!error, fmt::format("cannot make the folder {}: {}; choose another with --out",
                                 folder.string(), error.message()));
  return folder / kFileName;
}

bool HoldsTrials(const Database& db) { return Statement(db, "SELECT 1 FROM trials").Step(); }

// Between transactions the journal stays, with its head wiped out, which no program takes for a
// transaction to be taken back: making and removing the file anew each time costs more syncs of its
// folder than the trial's own rows. It is as safe, since what is synced before a commit is the
// same.
void KeepJournal(const Database& db) { db.Execute("PRAGMA journal_mode = PERSIST"); }

// Only leaving PERSIST removes the file, and only while nobody writes: other writers, which make it
// anew, may stay.
void RemoveJournal(const Database& db) {
  KeepJournal(db);
  db.Execute("PRAGMA journal_mode = DELETE");
}

// A run that failed before its first trial ended leaves nothing to be kept apart from.
void WriteHead(const Database& db, const StoreHead& head) {
  db.Execute("DELETE FROM points");
  std::vector<PointRow> rows;
  for (const StoredPoint& point : head.points) rows.push_back({point});
  Insert(db, "points", std::move(rows));
  Statement insert(db, "INSERT OR REPLACE INTO settings VALUES ('scenario', ?)");
  insert.Bind(1, head.identity);
  insert.Step();
}

// More trials may be asked for than before, and what leaves the identity as it is may change.
void UpdatePoints(const Database& db, const StoreHead& head) {
  Statement update(db, "UPDATE points SET trials = max(trials, ?), settings = ? WHERE point = ?");
  for (const StoredPoint& point : head.points) {
    update.Bind(1, point.trials);
    update.Bind(2, point.settings);
    update.Bind(3, point.point);
    update.Step();
  }
}

StoreHead ReadHead(const Database& db) {
  StoreHead head;
  head.identity = db.Setting("scenario");
  for (PointRow& row : Select<PointRow>(db, "points", "ORDER BY point")) {
    head.points.push_back(std::move(row.point));
  }
  return head;
}

StoreHead OnePoint(const std::string& settings) {
  StoredPoint point;
  point.identity = point.settings = settings;
  point.seed = SeedIn(settings);
  return {settings, {point}};
}

}  // namespace

struct ResultsStore::Impl {
  Database db;
  StoreHead head;
  bool writes = false;

  ~Impl() {
    if (!writes) return;
    try {
      RemoveJournal(db);
    } catch (const std::exception&) {  // it is in nobody's way
    }
  }

  // Throws std::logic_error for a point that the store does not have.
  uint64_t SeedOf(int point) const { return head.points.at(point).seed; }
};

uint64_t SeedIn(const std::string& settings) {
  constexpr std::string_view kKey = "seed: ";
  const std::string text = "\n" + settings;
  const size_t at = text.find("\n" + std::string(kKey));
  return at == std::string::npos ? 0 : std::strtoull(&text[at + 1 + kKey.size()], nullptr, 10);
}

std::optional<std::string> StoredSettings(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kFileName;
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const Database db(file, Database::Mode::kExisting);
  const bool is_new = !Statement(db, "SELECT 1 FROM sqlite_master").Step();
  if (is_new) return std::nullopt;  // its writer is just making the tables
  return ResultsStore::OpenToRead(folder).head().identity;
}

ResultsStore::ResultsStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ResultsStore::ResultsStore(ResultsStore&&) noexcept = default;
ResultsStore::~ResultsStore() = default;

ResultsStore::ResultsStore(const std::filesystem::path& folder, const std::string& settings)
    : ResultsStore(folder, OnePoint(settings)) {}

ResultsStore::ResultsStore(const std::filesystem::path& folder, const StoreHead& head) {
  Database db(FileIn(folder), Database::Mode::kCreate);
  // The rollback journal stays: turning a new file to WAL fails when several workers do it at once
  // (no busy timeout covers that), and WAL needs memory that machines of a cluster do not share.
  KeepJournal(db);
  Transaction transaction(db);
  RequireKnownVersion(db);
  if (!IsOfThisVersion(db)) Migrate(db);
  if (!HoldsTrials(db)) WriteHead(db, head);
  CheckInput(db.Setting("scenario") == head.identity,
             fmt::format("{} already holds results of another scenario or of other settings; "
                         "choose another folder with --out or remove this one",
                         folder.string()));
  UpdatePoints(db, head);
  transaction.Commit();
  StoreHead stored = ReadHead(db);
  impl_ = std::make_unique<Impl>(std::move(db), std::move(stored), /*writes=*/true);
}

ResultsStore ResultsStore::OpenToRead(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kFileName;
  CheckInput(std::filesystem::is_regular_file(file),
             fmt::format("{} holds no {}; name the results folder of a `pickbed run` or `pickbed "
                         "sweep`",
                         folder.string(), kFileName));
  Database db(file, Database::Mode::kExisting);
  RequireKnownVersion(db);
  CheckInput(db.HasTable("trials") && db.HasTable("settings"),
             fmt::format("{} is no results store of pickbed", file.string()));
  if (IsOfThisVersion(db)) {
    StoreHead head = ReadHead(db);
    return ResultsStore(std::make_unique<Impl>(std::move(db), std::move(head)));
  }
  Database copy = db.CopyInMemory();
  Migrate(copy);
  StoreHead head = ReadHead(copy);
  return ResultsStore(std::make_unique<Impl>(std::move(copy), std::move(head)));
}

void ResultsStore::Tidy(const std::filesystem::path& folder) {
  RemoveJournal(Database(folder / kFileName, Database::Mode::kExisting));
}

const StoreHead& ResultsStore::head() const { return impl_->head; }

void ResultsStore::Write(const TrialResult& result) {
  std::vector<PickRow> picks;
  std::vector<HypothesisRow> hypotheses;
  std::vector<InstanceRow> instances;
  std::vector<FateRow> fates;
  std::vector<RejectionRow> rejections;
  std::vector<RefusalRow> refusals;
  std::vector<BandRow> bands;
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
  for (size_t i = 0; i < result.bands.size(); ++i) {
    bands.push_back({trial, static_cast<int>(i), result.bands[i]});
  }
  for (const auto& [stage, seconds] : result.seconds) timings.push_back({trial, stage, seconds});

  const Database& db = impl_->db;
  Transaction transaction(db);
  Insert<TrialRow>(db, "trials",
                   {{trial, result, impl_->SeedOf(result.point), kFinished, /*crash=*/""}});
  Insert(db, "picks", std::move(picks));
  Insert(db, "hypotheses", std::move(hypotheses));
  Insert(db, "instances", std::move(instances));
  Insert(db, "fates", std::move(fates));
  Insert(db, "rejections", std::move(rejections));
  Insert(db, "refusals", std::move(refusals));
  Insert(db, "bands", std::move(bands));
  Insert(db, "timings", std::move(timings));
  transaction.Commit();
}

void ResultsStore::WriteCrashed(const CrashedTrial& crashed) {
  TrialRow row;
  row.trial = crashed.trial;
  row.result.point = crashed.point;
  row.result.scene = crashed.scene;
  row.seed = impl_->SeedOf(crashed.point);
  row.status = kCrashed;
  row.crash = crashed.why;
  Transaction transaction(impl_->db);
  Insert<TrialRow>(impl_->db, "trials", {row});
  transaction.Commit();
}

void ResultsStore::ForgetCrashed() {
  impl_->db.Execute(fmt::format("DELETE FROM trials WHERE status = '{}'", kCrashed));
}

void ResultsStore::Forget(const std::vector<int>& trials) {
  const std::string clause = fmt::format("WHERE trial IN ({})", fmt::join(trials, ","));
  Transaction transaction(impl_->db);
  ForEachTrialTable([&]<typename Row>(const char* table) {
    impl_->db.Execute(fmt::format("DELETE FROM {} {}", table, clause));
  });
  transaction.Commit();
}

std::vector<int> ResultsStore::FinishedTrials() const {
  std::vector<int> trials;
  Statement statement(impl_->db, "SELECT trial FROM trials ORDER BY trial");
  while (statement.Step()) statement.Read(0, trials.emplace_back());
  return trials;
}

std::vector<CrashedTrial> ResultsStore::Crashed() const {
  std::vector<CrashedTrial> crashed;
  const std::string clause = fmt::format("WHERE status = '{}' ORDER BY trial", kCrashed);
  for (TrialRow& row : Select<TrialRow>(impl_->db, "trials", clause)) {
    crashed.push_back(
        {row.trial, row.result.point, row.result.scene, row.seed, std::move(row.crash)});
  }
  return crashed;
}

std::map<int, Cluster> ResultsStore::Outcomes() const {
  Statement statement(impl_->db,
                      "SELECT trial, sum(executed AND loss = ?), sum(executed) FROM picks GROUP BY "
                      "trial ORDER BY trial");
  statement.Bind(1, Loss::kNone);
  std::map<int, Cluster> outcomes;
  while (statement.Step()) {
    int trial = 0;
    statement.Read(0, trial);
    Cluster& outcome = outcomes[trial];
    statement.Read(1, outcome.hits);
    statement.Read(2, outcome.tries);
  }
  return outcomes;
}

std::vector<TrialResult> ResultsStore::ReadAll() const {
  return Read(0, std::numeric_limits<int>::max());
}

void ResultsStore::ForEach(const std::function<void(const TrialResult&)>& visit) const {
  const std::vector<int> trials = FinishedTrials();
  for (size_t from = 0; from < trials.size(); from += kTrialsAtATime) {
    const size_t last = std::min(from + kTrialsAtATime, trials.size()) - 1;
    for (const TrialResult& result : Read(trials[from], trials[last] + 1)) visit(result);
  }
}

std::vector<TrialResult> ResultsStore::Read(int first, int end) const {
  const Database& db = impl_->db;
  // Rows of a trial were written in order and in one transaction.
  const std::string range =
      fmt::format("WHERE trial >= {} AND trial < {} ORDER BY trial, rowid", first, end);
  std::vector<TrialResult> results;
  std::map<int, size_t> index;
  for (TrialRow& row : Select<TrialRow>(db, "trials", range)) {
    if (row.status == kCrashed) continue;
    index[row.trial] = results.size();
    results.push_back(std::move(row.result));
    results.back().trial = row.trial;
  }
  const auto of = [&](int trial) -> TrialResult& { return results[index.at(trial)]; };
  for (PickRow& row : Select<PickRow>(db, "picks", range)) {
    if (row.executed) row.record.grasp = row.grasp;
    of(row.trial).picks.push_back(std::move(row.record));
  }
  for (HypothesisRow& row : Select<HypothesisRow>(db, "hypotheses", range)) {
    of(row.trial).picks[row.pick].hypotheses.push_back(row.score);
  }
  for (InstanceRow& row : Select<InstanceRow>(db, "instances", range)) {
    of(row.trial).picks[row.pick].instances.push_back(row.record);
  }
  for (const FateRow& row : Select<FateRow>(db, "fates", range))
    of(row.trial).fates.push_back(row.fate);
  for (const RejectionRow& row : Select<RejectionRow>(db, "rejections", range)) {
    of(row.trial).picks[row.pick].grasps_rejected[row.cause] = row.grasps;
  }
  for (const RefusalRow& row : Select<RefusalRow>(db, "refusals", range)) {
    std::vector<RefusedScene>& refused = of(row.trial).refused;
    if (refused.empty() || refused.back().attempt != row.attempt) {
      refused.push_back({row.attempt, {}});
    }
    refused.back().faults.push_back(row.fault);
  }
  for (const BandRow& row : Select<BandRow>(db, "bands", range)) {
    of(row.trial).bands.push_back(row.account);
  }
  for (const TimingRow& row : Select<TimingRow>(db, "timings", range)) {
    of(row.trial).seconds[row.stage] = row.seconds;
  }
  return results;
}

}  // namespace pickbed
