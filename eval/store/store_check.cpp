#include "eval/store/store_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "eval/store/former_names.h"
#include "eval/store/schema_internal.h"
#include "eval/trial/timed_stages.h"
#include "scenes/base/ids_format.h"
#include "scenes/base/message_text.h"
#include "scenes/base/random.h"
#include "scenes/scenario/scenario_text.h"

namespace pickbed::eval {
namespace {

// The pages of larger files are not checked, because that takes longer than reading the results.
constexpr double kLargestCheckedBytes = 64e6;

void CheckPages(const Database& db) {
  Statement size(db, "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size");
  size.Step();
  double bytes = 0;
  size.Read(0, bytes);
  if (bytes > kLargestCheckedBytes) return;
  Statement check(db, "PRAGMA quick_check(1)");
  check.Step();
  std::string answer;
  check.Read(0, answer);
  CheckInput(answer == "ok", fmt::format("{}: the file is damaged ({}); {}", db.file(),
                                         OneLine(answer), kRestoreAdvice));
}

constexpr double kMaxCount = 2147483647;
constexpr double kLongest_m = 1000;  // far more than the errors of any cell
constexpr double kHalfTurn_rad = 3.15;

// Values that a column can have. The measurements of an attempt are not among them, since a body
// may have any state after the physics failed.
struct ColumnRange {
  const char* column;
  double low = 0;
  double high = kMaxCount;
};
constexpr ColumnRange kTrialRanges[] = {
    {"bin_index"},
    {"instances_dropped"},
    {"instances_cleared"},
    {"simulated_s"},
    {"max_speed_mps"},
    {"max_spin_radps"},
    {"deepest_penetration_m"},
    {"wake_movement_m"},
    {"wake_movement_diameters"},
    {"instances_tested"},
    {"instances_graspable"},
    {"hand_eye_x_m", -kLongest_m, kLongest_m},
    {"hand_eye_y_m", -kLongest_m, kLongest_m},
    {"hand_eye_z_m", -kLongest_m, kLongest_m},
    {"hand_eye_rx_rad", -kHalfTurn_rad, kHalfTurn_rad},
    {"hand_eye_ry_rad", -kHalfTurn_rad, kHalfTurn_rad},
    {"hand_eye_rz_rad", -kHalfTurn_rad, kHalfTurn_rad},
    {"depth_bias_m", -kLongest_m, kLongest_m},
    {"bin_x_m", -kLongest_m, kLongest_m},
    {"bin_y_m", -kLongest_m, kLongest_m},
    {"bin_z_m", -kLongest_m, kLongest_m},
    {"bin_rx_rad", -kHalfTurn_rad, kHalfTurn_rad},
    {"bin_ry_rad", -kHalfTurn_rad, kHalfTurn_rad},
    {"bin_rz_rad", -kHalfTurn_rad, kHalfTurn_rad},
};
constexpr ColumnRange kAttemptRanges[] = {
    {"instances_lifted"},
    {"instances_touched"},
    {"instances_risen"},
    {"instances_entangled"},
    {"neighbors_displaced"},
    {"pick_of_image"},
    {"layer"},
    {"band", -1},
    {"target", -1},
    {"matched_instance", -1},
    {"picked_instance", -1},
    {"instances_above", -1},
    {"instances_below", -1},
};
constexpr ColumnRange kRejectionRanges[] = {{"grasps"}};
constexpr ColumnRange kBandRanges[] = {
    {"targets_given_up"}, {"blockers"},        {"blockers_kept"},
    {"blockers_refused"}, {"blockers_jumped"}, {"blockers_useless"},
};

template <typename Row>
void CheckColumns(const Database& db, const std::string& table) {
  for (const std::string& column : ColumnsOf<Row>()) {
    Statement info(db, "SELECT 1 FROM pragma_table_info(?) WHERE name = ?");
    info.Bind(1, table);
    info.Bind(2, column);
    CheckInput(info.Step(), fmt::format("{}: table '{}' has no column '{}'; {}", db.file(), table,
                                        column, kRestoreAdvice));
  }
}

// Throws the error of the first row that a query finds. Its first column is the row's number.
void RequireNoRow(const Database& db, const std::string& table, const std::string& query,
                  const std::string& fault) {
  Statement statement(db, query + " LIMIT 1");
  if (!statement.Step()) return;
  int row = 0;
  statement.Read(0, row);
  ThrowDamaged(db, table, fmt::format("row {}", row), fault);
}

// Requires that all values of these columns are in their ranges. The table is read once.
void RequireRanges(const Database& db, const std::string& table,
                   std::span<const ColumnRange> ranges) {
  std::string first_fault, any_fault;
  for (const ColumnRange& range : ranges) {
    const std::string fault =
        fmt::format("NOT {} BETWEEN {} AND {}", range.column, range.low, range.high);
    first_fault += fmt::format(" WHEN {} THEN '{}'", fault, range.column);
    any_fault += (any_fault.empty() ? "" : " OR ") + fault;
  }
  Statement statement(db, fmt::format("SELECT rowid, CASE{} END FROM {} WHERE {} LIMIT 1",
                                      first_fault, table, any_fault));
  if (!statement.Step()) return;
  int row = 0;
  std::string column;
  statement.Read(0, row);
  statement.Read(1, column);
  for (const ColumnRange& range : ranges) {
    if (range.column != column) continue;
    ThrowDamaged(db, table, fmt::format("row {}", row),
                 fmt::format("the value in column '{}' is not from {} to {}", range.column,
                             range.low, range.high));
  }
}

// Requires that the rows of `table` with equal `keys` are numbered from 0 without a gap.
void RequireNumbered(const Database& db, const std::string& table, const std::string& keys,
                     const std::string& number) {
  RequireNoRow(db, table,
               fmt::format("SELECT min(rowid) FROM {0} GROUP BY {1} HAVING min({2}) <> 0 OR "
                           "max({2}) <> count(*) - 1 OR count(DISTINCT {2}) <> count(*)",
                           table, keys, number),
               fmt::format("the numbers in column '{}' of its trial have a gap", number));
}

// Requires that no two rows of `table` have equal `keys`.
void RequireUnique(const Database& db, const std::string& table, const std::string& keys) {
  RequireNoRow(
      db, table,
      fmt::format("SELECT max(rowid) FROM {0} GROUP BY {1} HAVING count(*) > 1", table, keys),
      fmt::format("another row has the same {}", keys));
}

// Requires that the first and the last trial of a table exist. The reader refuses the trials
// between them that do not exist.
void RequireTrials(const Database& db, const std::string& table) {
  RequireNoRow(
      db, table,
      fmt::format("SELECT rowid FROM {0} WHERE (trial IS NULL OR trial IN (SELECT min(trial) FROM "
                  "{0} UNION ALL SELECT max(trial) FROM {0})) AND NOT EXISTS (SELECT 1 FROM trials "
                  "WHERE trials.trial = {0}.trial AND status = '{1}')",
                  table, kFinished),
      "table 'trials' has no such finished trial");
}

// Requires that column `number` of `table` is below the number of rows of `owner` with equal keys.
void RequireOwner(const Database& db, const std::string& table, const std::string& owner,
                  const std::string& keys, const std::string& number) {
  RequireNoRow(
      db, table,
      fmt::format("SELECT {0}.rowid FROM {0} LEFT JOIN (SELECT {2}, count(*) AS owners FROM {1} "
                  "GROUP BY {2}) USING ({2}) WHERE owners IS NULL OR {0}.{3} < 0 OR {0}.{3} >= "
                  "owners",
                  table, owner, keys, number),
      fmt::format("table '{}' has no such {}", owner, number));
}

}  // namespace

void ThrowDamaged(const Database& db, const std::string& table, const std::string& place,
                  const std::string& fault) {
  throw InputError(
      fmt::format("{}: table '{}', {}: {}; {}", db.file(), table, place, fault, kRestoreAdvice));
}

namespace {

// The settings of a sweep have a line "... HASH: NAME" for each configuration. Configurations that
// differ only in the times of a cycle have the same hash. A merged store puts the name of a folder
// before the name in its table.
class ConfigurationNames {
 public:
  explicit ConfigurationNames(const std::string& head) {
    std::istringstream lines(head);
    for (std::string line; std::getline(lines, line);) {
      constexpr size_t kHashLength = 16;
      const size_t colon = line.find(": ");
      if (!line.starts_with("configuration ") || colon == std::string::npos) continue;
      const size_t begin = std::max(colon, kHashLength) - kHashLength;
      names_[line.substr(begin, colon - begin)].insert(line.substr(colon + 2));
    }
  }
  // Returns whether some line has the name. True if no line has the hash.
  bool Has(const std::string& hash, const std::string& name) const {
    const auto found = names_.find(hash);
    if (found == names_.end() || found->second.contains("")) return true;
    for (size_t begin = 0; begin != std::string::npos;) {
      const std::string rest = name.substr(begin);
      if (found->second.contains(rest) || found->second.contains(NameWithCurrentNames(rest))) {
        return true;
      }
      const size_t colon = name.find(':', begin);
      begin = colon == std::string::npos ? colon : colon + 1;
    }
    return false;
  }

 private:
  std::map<std::string, std::set<std::string>> names_;  // by hash
};

}  // namespace

// The settings of the store have the identity of each configuration, or its hash.
void CheckIdentities(const Database& db) {
  const std::string head = "\n" + db.Setting("scenario") + "\n";
  const ConfigurationNames names(head);
  ForEachRow<ConfigurationRow>(db, "configurations", "", [&](const ConfigurationRow& row) {
    const StoredConfiguration& configuration = row.configuration;
    const std::string& identity = configuration.identity;
    const std::string hash = fmt::format("{:016x}", HashBytes(identity.data(), identity.size()));
    const bool is_known = head.find("\n" + identity) != std::string::npos && !identity.empty();
    const bool is_listed = head.find(hash) != std::string::npos;
    if (is_known || (is_listed && names.Has(hash, configuration.name))) return;
    ThrowDamaged(db, "configurations", fmt::format("configuration {}", configuration.number),
                 is_listed ? fmt::format("the settings of the store have another name than '{}'",
                                         OneLine(configuration.name))
                           : "its identity is not in the settings of the store");
  });
}

void CheckTables(const Database& db) {
  CheckPages(db);
  CheckColumns<ConfigurationRow>(db, "configurations");
  ForEachTrialTable([&]<typename Row>(const char* table) { CheckColumns<Row>(db, table); });
  RequireNumbered(db, "configurations", "'all'", "configuration");
  CheckIdentities(db);
  RequireNoRow(
      db, "configurations",
      fmt::format("SELECT rowid FROM configurations WHERE first_trial < 0 OR trials < 0 OR "
                  "first_trial + trials > {}",
                  kMaxStoredTrials),
      fmt::format("its trials are not between 0 and {}", kMaxStoredTrials));
  RequireNoRow(db, "trials",
               "SELECT rowid FROM trials WHERE configuration NOT IN (SELECT configuration FROM "
               "configurations)",
               "table 'configurations' has no such configuration");
  RequireNoRow(
      db, "trials",
      fmt::format("SELECT rowid FROM trials WHERE status NOT IN ('{}', '{}')", kFinished, kCrashed),
      fmt::format("its status is neither {} nor {}", kFinished, kCrashed));
  RequireNoRow(
      db, "trials",
      fmt::format("SELECT rowid FROM trials WHERE status = '{}' AND crash <> ''", kFinished),
      "it is finished and names a crash");
  RequireNoRow(
      db, "trials",
      fmt::format("SELECT rowid FROM trials WHERE trial IS NULL OR trial < 0 OR trial >= {}",
                  kMaxStoredTrials),
      "the number of the trial is missing, negative or too large");
  ForEachTrialTable([&]<typename Row>(const char* table) {
    if (!std::is_same_v<Row, TrialRow>) RequireTrials(db, table);
  });
  RequireRanges(db, "trials", kTrialRanges);
  RequireRanges(db, "attempts", kAttemptRanges);
  RequireRanges(db, "rejections", kRejectionRanges);
  RequireRanges(db, "bands", kBandRanges);
  RequireNoRow(db, "trials",
               "SELECT rowid FROM trials WHERE instances_graspable > instances_tested",
               "more instances are graspable than were tested");
}

void CheckRows(const Database& db) {
  ForEachTrialTable([&]<typename Row>(const char* table) {
    if (std::is_same_v<Row, TrialRow>) return;
    RequireNoRow(db, table,
                 fmt::format("SELECT rowid FROM {} WHERE trial NOT IN (SELECT trial FROM trials "
                             "WHERE status = '{}')",
                             table, kFinished),
                 "table 'trials' has no such trial");
  });
  RequireNumbered(db, "attempts", "trial", "attempt");
  for (const char* table : {"hypotheses", "instances", "rejections"}) {
    RequireOwner(db, table, "attempts", "trial", "attempt");
  }
  RequireNumbered(db, "hypotheses", "trial, attempt", "hypothesis");
  RequireOwner(db, "hypothesis_metrics", "hypotheses", "trial, attempt", "hypothesis");
  RequireUnique(db, "hypothesis_metrics", "trial, attempt, hypothesis, metric");
  RequireNoRow(db, "hypothesis_metrics",
               "SELECT rowid FROM hypothesis_metrics WHERE metric NOT GLOB '[a-z]*' OR metric GLOB "
               "'*[^a-z0-9_]*'",
               "the name in column 'metric' is none");
  RequireUnique(db, "instances", "trial, attempt, instance");
  RequireUnique(db, "rejections", "trial, attempt, cause");
  RequireUnique(db, "instance_outcomes", "trial, instance, attempt");
  RequireNoRow(db, "instance_outcomes",
               "SELECT max(rowid) FROM instance_outcomes GROUP BY trial, instance HAVING "
               "min(object) <> max(object)",
               "another row has the same instance with another object");
  RequireUnique(db, "refusals", "trial, attempt, fault");
  // A refused scene has a row for each of its faults.
  RequireNoRow(db, "refusals",
               "SELECT min(rowid) FROM refusals GROUP BY trial HAVING min(attempt) <> 0 OR "
               "max(attempt) <> count(DISTINCT attempt) - 1",
               "the numbers in column 'attempt' of its trial have a gap");
  RequireNumbered(db, "bands", "trial", "band");
  RequireUnique(db, "timings", "trial, stage");
  RequireNoRow(db, "timings", "SELECT rowid FROM timings WHERE seconds < 0",
               "its duration is negative");
  RequireNoRow(db, "trials",
               fmt::format("SELECT rowid FROM trials WHERE status = '{}' AND child_rows <> {}",
                           kFinished, ChildRowsOfTrial()),
               "the other tables have too few or too many rows of this trial");
  ForEachRow<TimingRow>(db, "timings", "GROUP BY stage", [&](const TimingRow& row) {
    ReadAt(db, "timings", fmt::format("trial {}", row.trial), [&] { CheckTiming(row); });
  });
}

void CheckTiming(const TimingRow& row) {
  CheckInput(IsTimedStage(CurrentStage(row.stage)),
             fmt::format("column 'stage': '{}' is no stage of a trial", OneLine(row.stage)));
  CheckInput(row.seconds >= 0 && std::isfinite(row.seconds),
             fmt::format("column 'seconds': {} is no duration of stage '{}'", row.seconds,
                         OneLine(row.stage)));
}

std::vector<SettingsCounts> SettingsCountsOf(const StoreHead& head,
                                             const std::filesystem::path& folder) {
  const std::string file = (folder / kStoreFile).string();
  std::vector<SettingsCounts> counts;
  for (const StoredConfiguration& configuration : head.configurations) {
    const ScenarioSpec spec = ScenarioOfText(configuration.settings, folder, file);
    counts.push_back({spec.objects.size(), spec.occlusion.bands.size()});
  }
  return counts;
}

void CheckTrial(const TrialResult& result, const SettingsCounts& settings,
                const std::string& file) {
  const auto check = [&](bool ok, const char* table, const std::string& fault) {
    if (ok) return;
    throw InputError(fmt::format("{}: table '{}', trial {}: {}; {}", file, table, result.trial,
                                 fault, kRestoreAdvice));
  };
  const auto check_object = [&](const char* table, ObjectId object) {
    check(object >= 0 && static_cast<size_t>(int{object}) < settings.objects, table,
          fmt::format("the settings have no object {}", object));
  };
  int succeeded = 0;
  for (const AttemptRecord& attempt : result.attempts) {
    for (const HypothesisRecord& row : attempt.hypotheses) check_object("hypotheses", row.object);
    for (const InstanceRecord& row : attempt.instances) check_object("instances", row.object);
    check(attempt.band >= -1 && attempt.band < static_cast<int>(settings.bands), "attempts",
          fmt::format("the settings have no band {}", attempt.band));
    const bool failed = attempt.failure != FailureReason::kNone;
    check(failed || attempt.grasp, "attempts",
          fmt::format("attempt {} has neither a grasp nor a failure", attempt.attempt));
    succeeded += !failed;
  }
  for (const InstanceOutcome& row : result.outcomes) check_object("instance_outcomes", row.object);
  check(succeeded == result.instances_cleared, "trials",
        fmt::format("{} attempts succeeded, but column 'instances_cleared' is {}", succeeded,
                    result.instances_cleared));
}

void CheckValues(const TrialResult& result) {
  const auto is_share = [](double value) { return value >= 0 && value <= 1; };
  // Returns the fault of a list that has an instance twice, else an empty text.
  const auto doubled = [](const std::vector<InstanceRecord>& records) -> std::string {
    std::vector<InstanceId> instances;
    for (const InstanceRecord& record : records) instances.push_back(record.instance);
    std::sort(instances.begin(), instances.end());
    const auto found = std::adjacent_find(instances.begin(), instances.end());
    return found == instances.end() ? "" : fmt::format("instance {} is there twice", *found);
  };
  CheckInput(result.instances_dropped >= 0 && result.instances_cleared >= 0,
             "a number of instances is negative");
  // The target of an occlusion trial has an outcome for each attempt.
  std::set<std::pair<InstanceId, int>> decided;
  std::map<InstanceId, ObjectId> objects;
  for (const InstanceOutcome& outcome : result.outcomes) {
    CheckInput(
        objects.emplace(outcome.instance, outcome.object).first->second == outcome.object,
        fmt::format("in table 'instance_outcomes', instance {} is two objects", outcome.instance));
    CheckInput(outcome.instance >= 0 && outcome.attempt >= -1,
               "in table 'instance_outcomes', the number of an instance or attempt is negative");
    CheckInput(outcome.deviation.friction >= -1 && outcome.deviation.mass >= -1 &&
                   outcome.size_deviation >= -1,
               "in table 'instance_outcomes', a deviation is under -1");
    CheckInput(
        decided.emplace(outcome.instance, outcome.attempt).second,
        fmt::format("in table 'instance_outcomes', instance {} is there twice", outcome.instance));
  }
  for (const AttemptRecord& attempt : result.attempts) {
    const auto check = [&](bool ok, const std::string& fault) {
      if (!ok) throw InputError(fmt::format("attempt {}: {}", attempt.attempt, fault));
    };
    const int hypotheses = static_cast<int>(attempt.hypotheses.size());
    check(attempt.chosen >= -1 && attempt.chosen < hypotheses,
          "the chosen hypothesis does not exist");
    for (const HypothesisRecord& hypothesis : attempt.hypotheses) {
      check(hypothesis.object >= 0 && hypothesis.instance >= kNoInstance,
            "the object or instance of a hypothesis is negative");
      check(std::isfinite(hypothesis.score), "the score of a hypothesis is not finite");
    }
    const std::string doubled_instance = doubled(attempt.instances);
    check(doubled_instance.empty(), "in table 'instances', " + doubled_instance);
    for (const InstanceRecord& instance : attempt.instances) {
      check(instance.object >= 0 && instance.instance >= 0,
            "the number of an instance or object is negative");
      check(is_share(instance.visible_fraction), "a visible fraction is not from 0 to 1");
    }
  }
}

}  // namespace pickbed::eval
