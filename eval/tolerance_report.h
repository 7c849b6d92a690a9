#pragma once

// Tables and files of a tolerance map.
//
//   FOLDER/tolerance.yaml   the settings that were in force
//   FOLDER/tries.csv        every execution, see eval/tolerance_tries.h
//   FOLDER/axes.csv         success by error along each axis, with intervals
//   FOLDER/pairs.csv        likewise of pairs, when asked for
//   FOLDER/predictors.csv   AUC of each score, with intervals
//   FOLDER/model.yaml       the fitted model, see grasp/tolerance.h
//   FOLDER/map.png          FOLDER/pairs.png

#include <filesystem>
#include <string>

#include "eval/tolerance_figures.h"

namespace pickbed {

// For people: regions of the axes, and how well scores foretell picks.
std::string ToleranceText(const ToleranceFigures& figures);
// One table of predictors; `picks` says of what.
std::string PredictorText(const std::vector<Predictor>& predictors, const std::string& picks);

// The same as cells, the header first.
std::vector<std::vector<std::string>> PredictorCells(const std::vector<Predictor>& predictors);

std::string AxesCsv(const ToleranceFigures& figures);
std::string PairsCsv(const ToleranceFigures& figures);
std::string PredictorsCsv(const std::vector<Predictor>& predictors);

void WriteToleranceFiles(const ToleranceStudy& study, const ToleranceFigures& figures,
                         const std::filesystem::path& folder);

}  // namespace pickbed
