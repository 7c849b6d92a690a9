#pragma once

// The tables of the results store, and how a file of an earlier version becomes one of this.
//
// A version that only adds tables or columns needs its rows (eval/results_rows.h) and a higher
// number here; one that derives their contents from what was there adds a step to Migrate().

#include "eval/results_rows.h"
#include "eval/results_sql_impl.h"

namespace pickbed {

inline constexpr int kSchemaVersion = 5;
inline constexpr int kOldestSchemaVersion = 4;  // that can be migrated

// Calls visit.template operator()<Row>("table") for each table whose rows belong to a trial.
template <typename Visitor>
void ForEachTrialTable(Visitor&& visit) {
  visit.template operator()<TrialRow>("trials");
  visit.template operator()<PickRow>("picks");
  visit.template operator()<HypothesisRow>("hypotheses");
  visit.template operator()<InstanceRow>("instances");
  visit.template operator()<FateRow>("fates");
  visit.template operator()<RejectionRow>("rejections");
  visit.template operator()<RefusalRow>("refusals");
  visit.template operator()<BandRow>("bands");
  visit.template operator()<TimingRow>("timings");
}

// Throws InputError for a store of a later version, or of one too old.
void RequireKnownVersion(const Database& db);
bool IsOfThisVersion(const Database& db);

// Makes all tables, in a file that is new or of an earlier version, in one transaction of the
// caller's.
void Migrate(const Database& db);

}  // namespace pickbed
