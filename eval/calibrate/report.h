#pragma once

// Text and page of a score calibration.

#include <string>

#include "eval/calibrate/fit.h"
#include "eval/page/html.h"

namespace pickbed::eval {

inline constexpr char kCalibrationFile[] = "calibration.yaml";
inline constexpr char kCalibrationPage[] = "calibration.html";

// Returns the numbers of samples and the table of the quality before and after, for the console.
std::string CalibrationText(const CalibrationFit& fit);
// Returns the page with the table, the fitted curves and reliability diagrams.
HtmlPage CalibrationReport(const CalibrationFit& fit);

}  // namespace pickbed::eval
