#pragma once

// Paired differences of points on the scenes that they share, as tables of a report.

#include <string>
#include <vector>

#include "eval/report_page.h"

namespace pickbed {

// One set of settings with what says whether its scenes are those of another.
struct PairedPoint {
  const PointTrials* trials = nullptr;
  std::string identity;  // of its store, see SceneKey in eval/paired_comparison.h
};

// Throws InputError when they share no scene.
ReportTable PairedReport(const PairedPoint& before, const PairedPoint& after);

// Each point against the first, as far as they have the same scenes.
std::vector<ReportTable> PairedWithFirst(const std::vector<PairedPoint>& points);

}  // namespace pickbed
