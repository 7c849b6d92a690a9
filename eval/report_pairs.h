#pragma once

// Paired differences of points on the scenes that they share: as tables of a report, as text and
// as JSON.

#include <span>
#include <string>
#include <vector>

#include "eval/paired_comparison.h"
#include "eval/report_page.h"

namespace pickbed {

// One set of settings with what says whether its scenes are those of another.
struct PairedPoint {
  const PointTrials* trials = nullptr;
  std::string identity;  // of its store, see SceneKey in eval/paired_comparison.h
};

struct PointComparison {
  std::string before, after;  // names of the points
  PairedComparison paired;
};

// Throws InputError when they share no scene.
PointComparison ComparePoints(const PairedPoint& before, const PairedPoint& after);

// Each point against the first, as far as they have the same scenes.
std::vector<PointComparison> CompareWithFirst(const std::vector<PairedPoint>& points);

ReportTable PairedReport(const PointComparison& comparison);
// For people: PairedTable of each.
std::string ComparisonText(std::span<const PointComparison> comparisons);
// {"comparisons": [{"first": NAME, "second": NAME, and what PairedJson holds}, ...]}
std::string ComparisonJson(std::span<const PointComparison> comparisons);

}  // namespace pickbed
