#pragma once

// Trains the network of perception/networks/wohlhart.h with triplets and pairs of crops. At regular
// intervals it mines the hardest wrong templates.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "perception/crops/crop_views.h"
#include "perception/networks/wohlhart.h"

namespace pickbed::perception {

// Inputs of a training.
struct WohlhartJob {
  const CropTrainingSet& training_set;
  uint64_t seed = 0;
  // Checkpoint, written after each round and at the end; empty = none. If the file exists, the
  // training resumes from it.
  std::filesystem::path checkpoint;
  std::function<bool(double share, double loss)> on_progress;  // false = stop; may be empty
  int threads = 1;
};

// Returns the trained network; null if stopped. The same seed gives the same weights, also after
// stops and for any number of threads. Throws InputError for a training set without views, and for
// a checkpoint with other settings, objects or views.
std::unique_ptr<WohlhartNetwork> TrainWohlhart(const WohlhartJob& job,
                                               const WohlhartOptions& options);

}  // namespace pickbed::perception
