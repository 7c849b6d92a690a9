#pragma once

// HTML page about a training: statistics, curves, and pictures of patches, answers and descriptors.

#include <filesystem>
#include <string>

#include "eval/layer.h"
#include "eval/metrics/result_columns.h"
#include "perception/training/training.h"

namespace pickbed::eval {

inline constexpr char kCurvesFile[] = "curves.csv";

// Content of the page.
struct TrainingPage {
  std::string name;  // name of the model
  std::string sensor;
  std::string settings;  // effective settings as YAML
  const TrainingReport& report;
  const ObjectSet& objects;
};

// Writes index.html, its pictures, curves.csv and timings.csv to `folder`, which is created.
// Returns an empty string, or the reason why the page is missing (WritePage in eval/page/html.h).
// Throws InputError if a file cannot be written.
[[nodiscard]] std::string WriteTrainingPage(const std::filesystem::path& folder,
                                            const TrainingPage& page);

// Columns of curves.csv and timings.csv. `objects` are the names of the trained objects.
ResultColumns CurvesColumns(const std::vector<std::string>& objects);
// Returns the columns of timings.csv.
ResultColumns TrainingTimingsColumns();

// Mean, minimum and maximum of an interval of a series; x is its center (index).
struct Stretch {
  double x = 0, mean = 0, minimum = 0, maximum = 0;
};
// Divides a series into at most `maximum` intervals of equal length.
std::vector<Stretch> Stretches(const std::vector<double>& values, int maximum);

}  // namespace pickbed::eval
