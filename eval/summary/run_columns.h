#pragma once

// Columns and keys of the files of a run or sweep (eval/summary/result_files.h).

#include "eval/metrics/result_columns.h"

namespace pickbed::eval {

ResultColumns TrialsColumns();            // trials.csv
ResultColumns AttemptsColumns();          // attempts.csv; includes the recorded metrics
ResultColumns InstancesColumns();         // instances.csv
ResultColumns InstanceOutcomesColumns();  // instance_outcomes.csv
ResultColumns ConfigurationsColumns();    // configurations.csv
ResultColumns TimingsColumns();           // timings.csv
ResultColumns CurveColumns();             // curve.csv
// Keys of summary.json of a run. In summary.json of a sweep, each configuration has the same keys.
ResultColumns SummaryKeys();

}  // namespace pickbed::eval
