#pragma once

// HTML page about a training: statistics, curves, and pictures of patches, answers and descriptors.

#include <filesystem>
#include <string>

#include "eval/layer.h"
#include "perception/training/training.h"

namespace pickbed::eval {

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

// Mean, minimum and maximum of an interval of a series; x is its center (index).
struct Stretch {
  double x = 0, mean = 0, least = 0, greatest = 0;
};
// Divides a series into at most `most` intervals of equal length.
std::vector<Stretch> Stretches(const std::vector<double>& values, int most);

}  // namespace pickbed::eval
