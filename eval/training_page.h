#pragma once

// What a training did, as a page for people: figures, curves, and pictures of patches, answers and
// descriptors.

#include <filesystem>
#include <string>

#include "perception/training.h"

namespace pickbed {

struct TrainingPage {
  std::string name;  // of the model
  std::string sensor;
  std::string settings;  // in force, as YAML
  const TrainingReport& report;
  const ObjectSet& objects;
};

// index.html, its pictures, curves.csv and timings.csv in `folder`, which is made. Throws
// InputError when it cannot be written.
void WriteTrainingPage(const std::filesystem::path& folder, const TrainingPage& page);

// Means over at most `most` stretches of equal length, each with its least and greatest value.
struct Stretch {
  double x = 0, mean = 0, least = 0, greatest = 0;
};
std::vector<Stretch> Stretches(const std::vector<double>& values, int most);

}  // namespace pickbed
