#pragma once

// Output of an estimator comparison as text, CSV and HTML page.

#include <string>
#include <vector>

#include "eval/estimate/estimator_comparison.h"
#include "eval/metrics/result_columns.h"
#include "eval/page/html.h"

namespace pickbed::eval {

inline constexpr char kComparisonFile[] = "comparison.csv";
inline constexpr char kHypothesesFile[] = "hypotheses.csv";

// Text table for the console, one column per estimator.
std::string ComparisonTable(const std::vector<ComparedRow>& rows);
// One line per estimator for all objects, and one per estimator and object.
std::string ComparisonCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects);
// One line per reported pose.
std::string HypothesesCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects);
// One line per estimator and instance in view, from which recall can be counted.
std::string InstancesCsv(const std::vector<ComparedRow>& rows, const ObjectSet& objects);
// Returns the columns of InstancesCsv().
ResultColumns EstimatedInstancesColumns();
// Returns the columns of ComparisonCsv().
ResultColumns EstimatorComparisonColumns();
// Returns the columns of HypothesesCsv().
ResultColumns HypothesesColumns();
// HTML page. `pictures` are paths of overlay images, relative to the page.
HtmlPage ComparisonPage(const std::string& title, const std::vector<ComparedRow>& rows,
                        const ObjectSet& objects, const std::vector<std::string>& pictures);

}  // namespace pickbed::eval
