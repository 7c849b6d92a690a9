#pragma once

// Tables and files of a tolerance map.
//
//   FOLDER/tolerance.yaml   the settings
//   FOLDER/samples.csv      every execution, see eval/tolerance/samples.h
//   FOLDER/axes.csv         success by error along each axis, with intervals
//   FOLDER/pairs.csv        success by errors along pairs of axes, if requested
//   FOLDER/predictors.csv   AUC of each score, with intervals
//   FOLDER/model.yaml       the fitted model, see grasp/tolerance/tolerance_model.h
//   FOLDER/map.png          the curves; FOLDER/pairs.png the heat maps of pairs

#include <filesystem>
#include <string>

#include "eval/metrics/result_columns.h"
#include "eval/tolerance/statistics.h"

namespace pickbed::eval {

inline constexpr char kToleranceFile[] = "tolerance.yaml";
inline constexpr char kAxesFile[] = "axes.csv";
inline constexpr char kPairsFile[] = "pairs.csv";
inline constexpr char kPredictorsFile[] = "predictors.csv";
inline constexpr char kRunPredictorsFile[] = "run_predictors.csv";  // for the picks of a run

// Console text: tolerated regions of the axes, and AUC of the scores.
std::string ToleranceText(const ToleranceStatistics& statistics);
// Console table of predictors; `picks` describes the picks they are evaluated on.
std::string PredictorText(const std::vector<Predictor>& predictors, const std::string& picks);

// The same table as cells, header first.
std::vector<std::vector<std::string>> PredictorCells(const std::vector<Predictor>& predictors);

// Returns axes.csv.
std::string AxesCsv(const ToleranceStatistics& statistics);
// Returns pairs.csv.
std::string PairsCsv(const ToleranceStatistics& statistics);
// Returns predictors.csv.
std::string PredictorsCsv(const std::vector<Predictor>& predictors);
// Returns the columns of AxesCsv().
ResultColumns AxesColumns();
// Returns the columns of PairsCsv().
ResultColumns PairsColumns();
// Returns the columns of PredictorsCsv().
ResultColumns PredictorsColumns();

// Writes all files above except samples.csv.
void WriteToleranceFiles(const ToleranceStudy& study, const ToleranceStatistics& statistics,
                         const std::filesystem::path& folder);

}  // namespace pickbed::eval
