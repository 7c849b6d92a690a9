#include <algorithm>

#include "eval/store/former_names.h"
#include "eval/store/schema_internal.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

// Scenario part of a run's identity, which continues with the settings of the gripper.
std::string ScenarioIn(const std::string& identity) {
  const size_t gripper = identity.find("\nmechanism:");
  return gripper == std::string::npos ? identity : identity.substr(0, gripper + 1);
}

// Renames of schema 6, in order: tables first.
struct RenamedTable {
  const char* was;
  const char* is;
};
constexpr RenamedTable kRenamedTables[] = {
    {"points", "configurations"}, {"picks", "attempts"}, {"fates", "instance_outcomes"}};

struct RenamedColumn {
  const char* table;  // name in schema 6
  const char* was;
  const char* is;
};
constexpr RenamedColumn kRenamedColumns[] = {
    {"configurations", "point", "configuration"},
    {"trials", "point", "configuration"},
    {"trials", "scene", "bin_index"},
    {"trials", "parts_dropped", "instances_dropped"},
    {"trials", "parts_cleared", "instances_cleared"},
    {"attempts", "pick", "attempt"},
    {"attempts", "loss", "failure"},
    {"attempts", "aimed", "matched_instance"},
    {"attempts", "physical_loss", "physical_failure"},
    {"attempts", "parts_lifted", "instances_lifted"},
    {"attempts", "turn_rad", "in_hand_rotation_error_rad"},
    {"attempts", "disturbed", "neighbors_displaced"},
    {"attempts", "parts_touched", "instances_touched"},
    {"attempts", "parts_risen", "instances_risen"},
    {"attempts", "set_down", "place_executed"},
    {"attempts", "place_turn_rad", "place_rotation_error_rad"},
    {"attempts", "right_part", "right_instance"},
    {"attempts", "single_part", "single_instance"},
    {"hypotheses", "pick", "attempt"},
    {"hypotheses", "x_otrue_obelieved", "x_oe"},
    {"instances", "pick", "attempt"},
    {"instance_outcomes", "loss", "failure"},
    {"instance_outcomes", "pick", "attempt"},
    {"rejections", "pick", "attempt"},
};

// Columns with names of failure reasons.
struct FailureColumn {
  const char* table;
  const char* column;
};
constexpr FailureColumn kFailureColumns[] = {
    {"trials", "ended_by"},  {"attempts", "failure"},          {"attempts", "physical_failure"},
    {"instances", "missed"}, {"instance_outcomes", "failure"},
};

bool HasColumn(const Database& db, const char* table, const char* column) {
  Statement info(db, "SELECT 1 FROM pragma_table_info(?) WHERE name = ?");
  info.Bind(1, std::string(table));
  info.Bind(2, std::string(column));
  return info.Step();
}

void ReplaceValue(const Database& db, const char* table, const char* column, std::string_view was,
                  std::string_view is) {
  Statement update(db, fmt::format("UPDATE {0} SET {1} = ? WHERE {1} = ?", table, column));
  update.Bind(1, std::string(is));
  update.Bind(2, std::string(was));
  update.Step();
}

// Gives tables, columns and values of schema 4 or 5 their names of schema 6.
void RenameToSchema6(const Database& db) {
  for (const RenamedTable& table : kRenamedTables) {
    if (!db.HasTable(table.was)) continue;
    db.Execute(fmt::format("ALTER TABLE {} RENAME TO {}", table.was, table.is));
    db.Execute(fmt::format("DROP INDEX IF EXISTS {}_by_trial", table.was));
  }
  for (const RenamedColumn& column : kRenamedColumns) {
    if (!HasColumn(db, column.table, column.was)) continue;
    db.Execute(
        fmt::format("ALTER TABLE {} RENAME COLUMN {} TO {}", column.table, column.was, column.is));
  }
  for (const FailureColumn& column : kFailureColumns) {
    if (!HasColumn(db, column.table, column.column)) continue;
    for (const FailureRow& row : FailureTable()) {
      if (row.former_name.empty()) continue;
      ReplaceValue(db, column.table, column.column, row.former_name, row.name);
    }
  }
  if (db.HasTable("rejections")) {
    for (const RenamedCause& cause : kRenamedCauses) {
      ReplaceValue(db, "rejections", "cause", cause.was, cause.is);
    }
  }
  if (!db.HasTable("timings")) return;
  for (const RenamedStage& stage : kRenamedStages) {
    ReplaceValue(db, "timings", "stage", stage.was, stage.is);
  }
}

// Columns of schema 4 and 5, whose names are the keys of metrics now.
constexpr const char* kMetricColumns[] = {"mssd_m",       "mspd_px",       "add_m",         "adi_m",
                                          "rotation_rad", "translation_m", "mssd_diameters"};

// Moves the metrics of schema 4 or 5 into their own table.
void MoveMetrics(const Database& db) {
  for (const std::string column : kMetricColumns) {
    if (!HasColumn(db, "hypotheses", column.c_str())) continue;
    db.Execute(fmt::format(
        "INSERT INTO hypothesis_metrics (trial, attempt, hypothesis, metric, value) SELECT trial, "
        "attempt, hypothesis, '{0}', {0} FROM hypotheses WHERE {0} IS NOT NULL ORDER BY rowid",
        column));
    db.Execute(fmt::format("ALTER TABLE hypotheses DROP COLUMN {}", column));
  }
}

// Version 4 held a single set of settings. It becomes one configuration in which the bin index
// equals the trial number.
void FillConfigurationOfVersion4(const Database& db) {
  ConfigurationRow row;
  row.configuration.identity = db.Setting("scenario");
  row.configuration.settings = ScenarioIn(row.configuration.identity);
  row.configuration.seed = SeedIn(row.configuration.identity);
  Statement count(db, "SELECT coalesce(max(trial) + 1, 0) FROM trials");
  count.Step();
  count.Read(0, row.configuration.trials);
  Insert<ConfigurationRow>(db, "configurations", {row});
  Statement update(db, "UPDATE trials SET bin_index = trial, seed = ?");
  update.Bind(1, row.configuration.seed);
  update.Step();
}

}  // namespace

std::string ChildRowsOfTrial() {
  std::string sum = "0";
  ForEachTrialTable([&]<typename Row>(const char* table) {
    if (std::is_same_v<Row, TrialRow> || std::is_same_v<Row, TimingRow>) return;
    sum += fmt::format(" + (SELECT count(*) FROM {0} WHERE {0}.trial = trials.trial)", table);
  });
  return sum;
}

void RequireKnownVersion(const Database& db) {
  // The version is written together with the tables. Another process may write them just now, so
  // they are looked for first.
  const bool has_tables = db.HasTable("trials") && db.HasTable("settings");
  const std::string text = db.Setting("schema_version");
  if (text.empty() && has_tables) {
    ThrowDamaged(db, "settings", "row 'schema_version'", "it is missing");
  }
  if (text.empty()) return;  // a new file
  const int version = std::atoi(text.c_str());
  CheckInput(version <= kSchemaVersion,
             fmt::format("{} was written by a later version of pickbed (schema {}, here {}); use "
                         "that version, or choose another results folder",
                         db.file(), text, kSchemaVersion));
  CheckInput(version >= kOldestSchemaVersion,
             fmt::format("{} was written by a version of pickbed that is too old to be read "
                         "(schema {}, here {} to {}); repeat the run into another results folder",
                         db.file(), text, kOldestSchemaVersion, kSchemaVersion));
}

bool IsOfThisVersion(const Database& db) {
  return db.Setting("schema_version") == std::to_string(kSchemaVersion);
}

StoreHead ReadHead(const Database& db) {
  StoreHead head;
  head.identity = db.Setting("scenario");
  for (ConfigurationRow& row :
       Select<ConfigurationRow>(db, "configurations", "ORDER BY configuration")) {
    head.configurations.push_back(std::move(row.configuration));
  }
  return head;
}

void WriteHead(const Database& db, const StoreHead& head) {
  db.Execute("DELETE FROM configurations");
  std::vector<ConfigurationRow> rows;
  for (const StoredConfiguration& configuration : head.configurations)
    rows.push_back({configuration});
  Insert(db, "configurations", std::move(rows));
  Statement insert(db, "INSERT OR REPLACE INTO settings VALUES ('scenario', ?)");
  insert.Bind(1, head.identity);
  insert.Step();
}

void Migrate(const Database& db) {
  const std::string version = db.Setting("schema_version");
  db.Execute("CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, value TEXT)");
  RenameToSchema6(db);  // changes nothing in a later version
  RequireTable<ConfigurationRow>(db, "configurations");
  const bool has_raw_scores = HasColumn(db, "hypotheses", "raw_score");
  const bool has_child_rows = HasColumn(db, "trials", "child_rows");
  ForEachTrialTable([&]<typename Row>(const char* table) {
    RequireTable<Row>(db, table);
    const bool one_row = std::is_same_v<Row, TrialRow>;
    db.Execute(fmt::format("CREATE {0} INDEX IF NOT EXISTS {1} ON {2} (trial)",
                           one_row ? "UNIQUE" : "",
                           one_row ? "one_row_a_trial" : fmt::format("{}_by_trial", table), table));
  });
  MoveMetrics(db);
  if (!has_raw_scores) db.Execute("UPDATE hypotheses SET raw_score = score");
  if (!has_child_rows) db.Execute("UPDATE trials SET child_rows = " + ChildRowsOfTrial());
  if (version == "4") FillConfigurationOfVersion4(db);
  if (!version.empty()) WriteHead(db, WithCurrentNames(ReadHead(db)));
  Statement insert(db, "INSERT OR REPLACE INTO settings VALUES ('schema_version', ?)");
  insert.Bind(1, std::to_string(kSchemaVersion));
  insert.Step();
}

}  // namespace pickbed::eval
