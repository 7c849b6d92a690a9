#pragma once

// Results of occlusion trials by the hidden share of the target, in the nine bands of the TARGO
// benchmark, beside its published curves.
//
// TARGO (Xia et al., "TARGO: Benchmarking Target-driven Object Grasping under Occlusions") is also
// simulated and counts only the target. Its rates are no baseline for the same task:
// HiddenShareNote() says what differs.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "eval/metrics/result_columns.h"
#include "eval/stats/statistics.h"
#include "eval/trial/trial.h"
#include "scenes/image/image.h"

namespace pickbed::eval {

inline constexpr int kHiddenBands = 9;

// Attempts with a target whose hidden share is in [hidden_min, hidden_max).
struct HiddenBand {
  double hidden_min = 0, hidden_max = 0;
  double mean_hidden = 0;       // 0 without attempts
  ReportRate recalled, picked;  // samples: attempts
};

// Published success of a method in the nine bands.
struct PublishedCurve {
  const char* method;
  const char* column;  // in CSV
  std::array<double, kHiddenBands> success;
};
// Returns the curves of the TARGO benchmark, the best method first.
std::span<const PublishedCurve> TargoCurves();
// Returns sentences on what differs between these trials and the published ones.
std::vector<std::string> HiddenShareNote();

// Returns the nine bands 0-10 %, ..., 80-90 % hidden; attempts without a target do not count. A
// share outside of all bands is not counted.
std::vector<HiddenBand> StatisticsByHiddenShare(std::span<const TrialResult> trials);

// Bands of one configuration of a sweep.
struct NamedHiddenCurve {
  std::string configuration;  // its name
  std::vector<HiddenBand> bands;
};

// Returns a CSV table with one line per configuration and band, with the published success of each
// method in the last columns.
std::string HiddenShareCsv(std::span<const NamedHiddenCurve> curves);
ResultColumns HiddenShareColumns();
// Draws pick success by hidden share over the published curves, with the note below.
Image<Rgb8> DrawHiddenShare(std::span<const NamedHiddenCurve> curves);

}  // namespace pickbed::eval
