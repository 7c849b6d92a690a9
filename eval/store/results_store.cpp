#include "eval/store/results_store.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "eval/store/schema_internal.h"
#include "eval/store/settings_difference.h"
#include "eval/store/store_check.h"
#include "eval/trial/timed_stages.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/random.h"

namespace pickbed::eval {
namespace {

constexpr int kTrialsAtATime = 256;  // block size of ForEach

std::filesystem::path FileIn(const std::filesystem::path& folder) {
  MakeFolder(folder);
  return folder / kStoreFile;
}

bool HoldsTrials(const Database& db) { return Statement(db, "SELECT 1 FROM trials").Step(); }

// Returns ResultsStore::Outcomes() of the attempts for which an SQL condition holds.
std::map<int, Cluster> OutcomesWhere(const Database& db, std::string_view condition) {
  Statement statement(
      db, fmt::format("SELECT trial, sum(executed AND failure = ?), sum(executed OR failure IN (?, "
                      "?)) FROM attempts WHERE {} GROUP BY trial ORDER BY trial",
                      condition));
  statement.Bind(1, FailureReason::kNone);
  statement.Bind(2, FailureReason::kStirred);
  statement.Bind(3, FailureReason::kPhysicsFailed);  // of a stir
  std::map<int, Cluster> outcomes;
  ReadAt(db, "attempts", "numbers of successes", [&] {
    while (statement.Step()) {
      int trial = 0;
      statement.Read(0, trial);
      Cluster& outcome = outcomes[trial];
      statement.Read(1, outcome.hits);
      statement.Read(2, outcome.samples);
    }
  });
  return outcomes;
}

// Keeps the journal file between transactions, with a zeroed header. No program takes such a
// journal for a transaction to roll back. Creating and removing the file for each transaction costs
// more syncs of the folder than the rows of a trial. It is as safe, since the same data is synced
// before a commit.
void KeepJournal(const Database& db) { db.Execute("PRAGMA journal_mode = PERSIST"); }

// SQLite removes the file only when a connection leaves PERSIST, and only while no other process
// writes. Other writers may continue, since they create the file again.
void RemoveJournal(const Database& db) {
  KeepJournal(db);
  db.Execute("PRAGMA journal_mode = DELETE");
}

// Updates values that may change on resume: a larger number of trials, and settings that are not
// part of the identity.
void UpdateConfigurations(const Database& db, const StoreHead& head) {
  Statement update(
      db,
      "UPDATE configurations SET trials = max(trials, ?), settings = ? WHERE configuration = ?");
  for (const StoredConfiguration& configuration : head.configurations) {
    update.Bind(1, configuration.trials);
    update.Bind(2, configuration.settings);
    update.Bind(3, configuration.number);
    update.Step();
  }
}

StoreHead OneConfiguration(const std::string& settings) {
  StoredConfiguration configuration;
  configuration.identity = configuration.settings = settings;
  configuration.seed = SeedIn(settings);
  return {settings, {configuration}};
}

// Returns " (estimator.mode: fast before, accurate now)", with the first few differences; empty if
// no setting differs, for example if a sweep has other configurations.
std::string HeadDifference(const StoreHead& before, const StoreHead& now) {
  constexpr size_t kShown = 5;
  std::vector<std::string> differences;
  const size_t both = std::min(before.configurations.size(), now.configurations.size());
  for (size_t i = 0; i < both; ++i) {
    for (std::string& difference :
         SettingsDifferences(before.configurations[i].identity, now.configurations[i].identity)) {
      if (std::find(differences.begin(), differences.end(), difference) == differences.end()) {
        differences.push_back(std::move(difference));
      }
    }
  }
  if (differences.empty()) return "";
  const size_t more = differences.size() - std::min(kShown, differences.size());
  differences.resize(differences.size() - more);
  const std::string others = more > 0 ? fmt::format("; and {} more", more) : "";
  return fmt::format(" ({}{})", fmt::join(differences, "; "), others);
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
    } catch (const std::exception&) {  // a remaining journal does no harm
    }
  }

  // Throws std::logic_error for a configuration that the store does not have.
  uint64_t SeedOf(int configuration) const { return head.configurations.at(configuration).seed; }
};

uint64_t SeedIn(const std::string& settings) {
  constexpr std::string_view kKey = "seed: ";
  const std::string text = "\n" + settings;
  const size_t at = text.find("\n" + std::string(kKey));
  return at == std::string::npos ? 0 : std::strtoull(&text[at + 1 + kKey.size()], nullptr, 10);
}

std::string ConfigurationIdentity(int number, int trials, const std::string& identity_hash,
                                  const std::string& name) {
  return fmt::format("configuration {} has {} trials {}: {}\n", number, trials, identity_hash,
                     name);
}

std::string SweepIdentity(const std::vector<StoredConfiguration>& configurations) {
  std::string text;
  for (const StoredConfiguration& c : configurations) {
    const uint64_t hash = HashBytes(c.identity.data(), c.identity.size());
    text += ConfigurationIdentity(c.number, c.trials, fmt::format("{:016x}", hash), c.name);
  }
  return text;
}

std::optional<std::string> StoredSettings(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / kStoreFile;
  if (!std::filesystem::is_regular_file(file)) return std::nullopt;
  const Database db(file, Database::Mode::kExisting);
  const bool is_new = !Statement(db, "SELECT 1 FROM sqlite_master").Step();
  if (is_new) return std::nullopt;  // another process is just creating the tables
  return ResultsStore::OpenToRead(folder, StoreChecks::kVersion).head().identity;
}

ResultsStore::ResultsStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ResultsStore::ResultsStore(ResultsStore&&) noexcept = default;
ResultsStore::~ResultsStore() = default;

ResultsStore::ResultsStore(const std::filesystem::path& folder, const std::string& settings)
    : ResultsStore(folder, OneConfiguration(settings)) {}

ResultsStore::ResultsStore(const std::filesystem::path& folder, const StoreHead& head) {
  Database db(FileIn(folder), Database::Mode::kCreate);
  // Rollback journal instead of WAL. Switching a new file to WAL fails if several workers do it at
  // the same time (the busy timeout does not cover this). WAL also needs shared memory, which the
  // machines of a cluster do not have.
  KeepJournal(db);
  Transaction transaction(db);
  RequireKnownVersion(db);
  if (!IsOfThisVersion(db)) Migrate(db);
  if (HoldsTrials(db)) CheckTables(db);
  // Without a trial, for example after a run that failed before the end of its first one, the
  // settings may change.
  if (!HoldsTrials(db)) WriteHead(db, head);
  if (db.Setting("scenario") != head.identity) {
    throw InputError(
        fmt::format("{} already has results of other settings{}; choose another results folder",
                    folder.string(), HeadDifference(ReadHead(db), head)));
  }
  UpdateConfigurations(db, head);
  transaction.Commit();
  StoreHead stored = ReadHead(db);
  impl_.reset(new Impl{std::move(db), std::move(stored), /*writes=*/true});
}

ResultsStore ResultsStore::OpenToRead(const std::filesystem::path& folder, StoreChecks checks) {
  const std::filesystem::path file = folder / kStoreFile;
  CheckInput(
      std::filesystem::is_regular_file(file),
      fmt::format("{} has no {}; name the results folder of a `pickbed run` or `pickbed sweep`",
                  folder.string(), kStoreFile));
  Database db(file, Database::Mode::kExisting);
  RequireKnownVersion(db);
  CheckInput(db.HasTable("trials") && db.HasTable("settings"),
             fmt::format("{} is no results store of pickbed", file.string()));
  if (IsOfThisVersion(db)) {
    if (checks != StoreChecks::kVersion) CheckTables(db);
    if (checks == StoreChecks::kRows) CheckRows(db);
    StoreHead head = ReadHead(db);
    return ResultsStore(std::unique_ptr<Impl>(new Impl{std::move(db), std::move(head)}));
  }
  Database copy = db.CopyInMemory();
  Migrate(copy);
  CheckTables(copy);
  if (checks == StoreChecks::kRows) CheckRows(copy);
  StoreHead head = ReadHead(copy);
  return ResultsStore(std::unique_ptr<Impl>(new Impl{std::move(copy), std::move(head)}));
}

void ResultsStore::Tidy(const std::filesystem::path& folder) {
  RemoveJournal(Database(folder / kStoreFile, Database::Mode::kExisting));
}

const StoreHead& ResultsStore::head() const { return impl_->head; }

void ResultsStore::Write(const TrialResult& result) {
  std::vector<AttemptRow> attempts;
  std::vector<HypothesisRow> hypotheses;
  std::vector<HypothesisMetricRow> metrics;
  std::vector<InstanceRow> instances;
  std::vector<InstanceOutcomeRow> outcomes;
  std::vector<RejectionRow> rejections;
  std::vector<RefusalRow> refusals;
  std::vector<BandRow> bands;
  std::vector<TimingRow> timings;
  const int trial = result.trial;
  for (const AttemptRecord& record : result.attempts) {
    attempts.push_back({trial, record, record.grasp.has_value(), record.grasp.value_or(Grasp())});
    for (size_t i = 0; i < record.hypotheses.size(); ++i) {
      const int hypothesis = static_cast<int>(i);
      hypotheses.push_back({trial, record.attempt, hypothesis, record.hypotheses[i]});
      for (const MetricValue& value : record.hypotheses[i].metrics) {
        // SQLite has no NaN. Without a row, Get() returns NaN.
        if (!std::isnan(value.value)) metrics.push_back({trial, record.attempt, hypothesis, value});
      }
    }
    for (const InstanceRecord& instance : record.instances) {
      instances.push_back({trial, record.attempt, instance});
    }
    for (const auto& [cause, grasps] : record.grasps_rejected) {
      rejections.push_back({trial, record.attempt, cause, grasps});
    }
  }
  for (const InstanceOutcome& instance_outcome : result.outcomes)
    outcomes.push_back({trial, instance_outcome});
  for (const RefusedScene& refused : result.refused) {
    for (const std::string& fault : refused.faults) {
      refusals.push_back({trial, refused.attempt, fault});
    }
  }
  for (size_t i = 0; i < result.bands.size(); ++i) {
    bands.push_back({trial, static_cast<int>(i), result.bands[i]});
  }
  for (const auto& [stage, seconds] : result.seconds) timings.push_back({trial, stage, seconds});

  // Without the timings: the stages of a trial may differ between versions of the program.
  const size_t child_rows = attempts.size() + hypotheses.size() + metrics.size() +
                            instances.size() + outcomes.size() + rejections.size() +
                            refusals.size() + bands.size();
  const Database& db = impl_->db;
  Transaction transaction(db);
  Insert<TrialRow>(db, "trials",
                   {{trial, static_cast<int>(child_rows), result,
                     impl_->SeedOf(result.configuration), kFinished, /*crash=*/""}});
  Insert(db, "attempts", std::move(attempts));
  Insert(db, "hypotheses", std::move(hypotheses));
  Insert(db, "hypothesis_metrics", std::move(metrics));
  Insert(db, "instances", std::move(instances));
  Insert(db, "instance_outcomes", std::move(outcomes));
  Insert(db, "rejections", std::move(rejections));
  Insert(db, "refusals", std::move(refusals));
  Insert(db, "bands", std::move(bands));
  Insert(db, "timings", std::move(timings));
  transaction.Commit();
}

void ResultsStore::WriteCrashed(const CrashedTrial& crashed) {
  TrialRow row;
  row.trial = crashed.trial;
  row.result.configuration = crashed.configuration;
  row.result.bin_index = crashed.bin_index;
  row.seed = impl_->SeedOf(crashed.configuration);
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
  ReadAt(impl_->db, "trials", "column 'trial'", [&] {
    while (statement.Step()) statement.Read(0, trials.emplace_back());
  });
  return trials;
}

std::vector<CrashedTrial> ResultsStore::Crashed() const {
  std::vector<CrashedTrial> crashed;
  const std::string clause = fmt::format("WHERE status = '{}' ORDER BY trial", kCrashed);
  for (TrialRow& row : Select<TrialRow>(impl_->db, "trials", clause)) {
    crashed.push_back({row.trial, row.result.configuration, row.result.bin_index, row.seed,
                       std::move(row.crash)});
  }
  return crashed;
}

std::map<int, Cluster> ResultsStore::Outcomes() const { return OutcomesWhere(impl_->db, "true"); }

std::optional<Cluster> ResultsStore::OutcomeOf(int trial) const {
  Statement statement(impl_->db, "SELECT 1 FROM trials WHERE trial = ? AND status = ?");
  statement.Bind(1, trial);
  statement.Bind(2, std::string(kFinished));
  if (!statement.Step()) return std::nullopt;
  return OutcomesWhere(impl_->db, fmt::format("trial = {}", trial))[trial];
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
  // The rows of a trial were written in order in one transaction, so rowid restores their order.
  const std::string range =
      fmt::format("WHERE trial >= {} AND trial < {} ORDER BY trial, rowid", first, end);
  std::vector<TrialResult> results;
  std::vector<int> rows_written, rows_found;  // of each result in the other tables
  std::map<int, size_t> index;
  for (TrialRow& row : Select<TrialRow>(db, "trials", range)) {
    if (row.status == kCrashed) continue;
    index[row.trial] = results.size();
    rows_written.push_back(row.child_rows);
    rows_found.push_back(0);
    results.push_back(std::move(row.result));
    results.back().trial = row.trial;
  }
  const auto fail = [&](const char* table, int trial, const std::string& fault) {
    ThrowDamaged(db, table, fmt::format("trial {}", trial), fault);
  };
  const auto of = [&](const char* table, int trial) -> TrialResult& {
    const auto found = index.find(trial);
    if (found == index.end()) fail(table, trial, "table 'trials' has no such finished trial");
    rows_found[found->second] += std::string_view(table) != "timings";
    return results[found->second];
  };
  const auto attempt_of = [&](const char* table, int trial, int attempt) -> AttemptRecord& {
    std::vector<AttemptRecord>& attempts = of(table, trial).attempts;
    if (attempt < 0 || attempt >= static_cast<int>(attempts.size())) {
      fail(table, trial, "table 'attempts' has no such attempt");
    }
    return attempts[attempt];
  };
  for (AttemptRow& row : Select<AttemptRow>(db, "attempts", range)) {
    std::vector<AttemptRecord>& attempts = of("attempts", row.trial).attempts;
    if (row.record.attempt != static_cast<int>(attempts.size())) {
      fail("attempts", row.trial, "the numbers of its attempts have a gap");
    }
    if (row.executed) row.record.grasp = row.grasp;
    attempts.push_back(std::move(row.record));
  }
  for (HypothesisRow& row : Select<HypothesisRow>(db, "hypotheses", range)) {
    AttemptRecord& attempt = attempt_of("hypotheses", row.trial, row.attempt);
    if (row.hypothesis != static_cast<int>(attempt.hypotheses.size())) {
      fail("hypotheses", row.trial, "the numbers of its hypotheses have a gap");
    }
    attempt.hypotheses.push_back(row.score);
  }
  constexpr const char* kMetrics = "hypothesis_metrics";
  ForEachRow<HypothesisMetricRow>(db, kMetrics, range, [&](HypothesisMetricRow& row) {
    AttemptRecord& attempt = attempt_of(kMetrics, row.trial, row.attempt);
    if (row.hypothesis < 0 || row.hypothesis >= static_cast<int>(attempt.hypotheses.size())) {
      fail(kMetrics, row.trial, "table 'hypotheses' has no such hypothesis");
    }
    MetricValues& metrics = attempt.hypotheses[row.hypothesis].metrics;
    if (!std::isnan(metrics.Get(row.value.metric))) {
      fail(kMetrics, row.trial,
           fmt::format("attempt {} has the metric '{}' of hypothesis {} twice", row.attempt,
                       OneLine(row.value.metric), row.hypothesis));
    }
    metrics.Set(row.value.metric, row.value.value);
  });
  for (InstanceRow& row : Select<InstanceRow>(db, "instances", range)) {
    attempt_of("instances", row.trial, row.attempt).instances.push_back(row.record);
  }
  for (const InstanceOutcomeRow& row : Select<InstanceOutcomeRow>(db, "instance_outcomes", range)) {
    of("instance_outcomes", row.trial).outcomes.push_back(row.instance_outcome);
  }
  for (const RejectionRow& row : Select<RejectionRow>(db, "rejections", range)) {
    AttemptRecord& attempt = attempt_of("rejections", row.trial, row.attempt);
    if (!attempt.grasps_rejected.emplace(row.cause, row.grasps).second) {
      fail("rejections", row.trial,
           fmt::format("attempt {} has the cause '{}' twice", row.attempt, OneLine(row.cause)));
    }
  }
  for (const RefusalRow& row : Select<RefusalRow>(db, "refusals", range)) {
    std::vector<RefusedScene>& refused = of("refusals", row.trial).refused;
    if (refused.empty() || refused.back().attempt != row.attempt) {
      if (row.attempt != static_cast<int>(refused.size())) {
        fail("refusals", row.trial, fmt::format("drop {} is not the next one", row.attempt));
      }
      refused.push_back({row.attempt, {}});
    }
    std::vector<std::string>& faults = refused.back().faults;
    if (std::ranges::find(faults, row.fault) != faults.end()) {
      fail("refusals", row.trial,
           fmt::format("drop {} has the fault '{}' twice", row.attempt, OneLine(row.fault)));
    }
    faults.push_back(row.fault);
  }
  for (const BandRow& row : Select<BandRow>(db, "bands", range)) {
    std::vector<BandAccount>& bands = of("bands", row.trial).bands;
    if (row.band != static_cast<int>(bands.size())) {
      fail("bands", row.trial,
           fmt::format("band {} is {}", row.band,
                       row.band >= 0 && row.band < static_cast<int>(bands.size())
                           ? "there twice"
                           : "not the next one"));
    }
    bands.push_back(row.account);
  }
  for (const TimingRow& row : Select<TimingRow>(db, "timings", range)) {
    ReadAt(db, "timings", fmt::format("trial {}", row.trial), [&] { CheckTiming(row); });
    StageSeconds& seconds = of("timings", row.trial).seconds;
    if (!seconds.emplace(CurrentStage(row.stage), row.seconds).second) {
      fail("timings", row.trial, fmt::format("stage '{}' is there twice", OneLine(row.stage)));
    }
  }
  for (const TrialResult& result : results) {
    try {
      CheckValues(result);
    } catch (const InputError& error) {
      ThrowDamaged(db, "trials", fmt::format("trial {}", result.trial), error.what());
    }
  }
  for (size_t i = 0; i < results.size(); ++i) {
    if (rows_found[i] == rows_written[i]) continue;
    fail("trials", results[i].trial,
         fmt::format("the other tables have {} of its {} rows", rows_found[i], rows_written[i]));
  }
  return results;
}

}  // namespace pickbed::eval
