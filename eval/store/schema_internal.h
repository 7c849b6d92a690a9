#pragma once

// Tables of the results store, and migration of files of earlier versions.
//
// A new version that only adds tables or columns needs new rows (eval/store/schema.h) and a higher
// number here. A version that computes new contents from old ones also needs a step in Migrate().

#include <string>

#include "eval/store/schema.h"
#include "eval/store/sqlite.h"

namespace pickbed::eval {

// 12: sideways shift of each lift
inline constexpr int kSchemaVersion = 12;
inline constexpr int kOldestSchemaVersion = 4;  // oldest version that can be migrated

// Calls visit.template operator()<Row>("table") for each table whose rows belong to a trial.
template <typename Visitor>
void ForEachTrialTable(Visitor&& visit) {
  visit.template operator()<TrialRow>("trials");
  visit.template operator()<AttemptRow>("attempts");
  visit.template operator()<HypothesisRow>("hypotheses");
  visit.template operator()<HypothesisMetricRow>("hypothesis_metrics");
  visit.template operator()<InstanceRow>("instances");
  visit.template operator()<InstanceOutcomeRow>("instance_outcomes");
  visit.template operator()<RejectionRow>("rejections");
  visit.template operator()<RefusalRow>("refusals");
  visit.template operator()<BandRow>("bands");
  visit.template operator()<TimingRow>("timings");
}

// Returns an SQL expression for the number of rows that trial `trials.trial` has in the other
// tables (TrialRow::child_rows).
std::string ChildRowsOfTrial();

// Throws InputError for a store of a later version, or of a version that is too old.
void RequireKnownVersion(const Database& db);
// Returns whether the store has kSchemaVersion.
bool IsOfThisVersion(const Database& db);

// Reads identity and configurations of a store of this version.
StoreHead ReadHead(const Database& db);
// Replaces the head.
void WriteHead(const Database& db, const StoreHead& head);

// Creates all tables and missing columns in a file that is new or of an earlier version. The caller
// opens the transaction.
void Migrate(const Database& db);

}  // namespace pickbed::eval
