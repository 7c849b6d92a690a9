#include <algorithm>

#include "eval/results_schema_impl.h"
#include "scenes/check.h"

namespace pickbed {
namespace {

// The scenario's part of a run's identity, which goes on with the gripper's settings.
std::string ScenarioIn(const std::string& identity) {
  const size_t gripper = identity.find("\nmechanism:");
  return gripper == std::string::npos ? identity : identity.substr(0, gripper + 1);
}

// Version 4 held one set of settings: one point, whose trials' scenes bear their number.
void FillPointOfVersion4(const Database& db) {
  PointRow row;
  row.point.identity = db.Setting("scenario");
  row.point.settings = ScenarioIn(row.point.identity);
  row.point.seed = SeedIn(row.point.identity);
  Statement count(db, "SELECT coalesce(max(trial) + 1, 0) FROM trials");
  count.Step();
  count.Read(0, row.point.trials);
  Insert<PointRow>(db, "points", {row});
  Statement update(db, "UPDATE trials SET scene = trial, seed = ?");
  update.Bind(1, row.point.seed);
  update.Step();
}

}  // namespace

void RequireKnownVersion(const Database& db) {
  const std::string text = db.Setting("schema_version");
  if (text.empty()) return;  // a new file
  const int version = std::atoi(text.c_str());
  CheckInput(version <= kSchemaVersion,
             fmt::format("{} was written by a later version of pickbed (schema {}, here {}); use "
                         "that one, or choose another folder with --out",
                         db.file(), text, kSchemaVersion));
  CheckInput(version >= kOldestSchemaVersion,
             fmt::format("{} was written by a version of pickbed that is too old to be read "
                         "(schema {}, here {} to {}); repeat the run into another folder with "
                         "--out",
                         db.file(), text, kOldestSchemaVersion, kSchemaVersion));
}

bool IsOfThisVersion(const Database& db) {
  return db.Setting("schema_version") == std::to_string(kSchemaVersion);
}

void Migrate(const Database& db) {
  const bool from_version_4 = db.Setting("schema_version") == "4";
  db.Execute("CREATE TABLE IF NOT EXISTS settings (key TEXT PRIMARY KEY, value TEXT)");
  RequireTable<PointRow>(db, "points");
  ForEachTrialTable([&]<typename Row>(const char* table) {
    RequireTable<Row>(db, table);
    const bool one_row = std::is_same_v<Row, TrialRow>;
    db.Execute(fmt::format("CREATE {0} INDEX IF NOT EXISTS {1} ON {2} (trial)",
                           one_row ? "UNIQUE" : "",
                           one_row ? "one_row_a_trial" : fmt::format("{}_by_trial", table), table));
  });
  if (from_version_4) FillPointOfVersion4(db);
  Statement insert(db, "INSERT OR REPLACE INTO settings VALUES ('schema_version', ?)");
  insert.Bind(1, std::to_string(kSchemaVersion));
  insert.Step();
}

}  // namespace pickbed
