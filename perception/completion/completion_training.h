#pragma once

// Trains the completion network on views that are made during the training. Threads sphere trace
// sampled shapes while the network trains. Step k draws its samples from a window of groups
// (DrawGroup()) whose position depends only on k, so the result does not depend on the threads.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perception/completion/completion_network.h"
#include "perception/completion/training_sample.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {

struct CompletionTrainingOptions {
  uint64_t seed = 0;
  int steps = 6500;
  int batch = 16;               // samples in a step
  int replicas = 2;             // parts of a step that are computed at the same time
  double learning_rate = 2e-3;  // of Adam; decays to zero along a cosine
  int warm_up = 50;             // steps in which the learning rate rises
  double max_minutes = 0;       // shortens the schedule; 0 = none
  int window = 128;             // groups of samples from which a step draws
  double uses = 2;              // mean number of steps that use a sample
  int held_out = 160;           // held-out views of each split
  int measure_every = 250;      // steps between measurements on held-out views
  int patience = 12;            // measurements without a better one that end the training; 0 = none
  int checkpoint_every = 250;   // steps
  int points = 2048;            // queries of a sample
  int views_per_shape = 4;
  int threads = 1;             // that make samples
  std::string device = "cpu";  // cpu or cuda
  CompletionNetworkOptions network;
  RandomViewOptions views;
  void Visit(SettingsVisitor& v);
};

// Quality on the held-out views of a split.
struct CompletionQuality {
  double loss = 0;          // mean cross-entropy
  double iou_clean = 0;     // mean IoU on the points of views without occluder
  double iou_occluded = 0;  // with occluder
};

// Held-out splits, in the order of measurements.
inline constexpr const char* kHeldOutSplits[] = {"seen", "unseen_sizes", "unseen_families"};
inline constexpr int kHeldOutSplitCount = 3;

struct CompletionMeasurement {
  int step = 0;
  CompletionQuality splits[kHeldOutSplitCount];
};

struct CompletionProgress {
  std::string phase;  // "held-out views", "network"
  int done = 0, total = 0;
  double loss = 0;           // mean of the last steps
  double iou = -1;           // on clean held-out views of seen families; -1 = not measured yet
  double seconds_left = -1;  // -1 = not known yet
};

struct CompletionJob {
  std::vector<ShapeDomain> domains;
  std::vector<DepthSensor> sensors;  // each view uses one of them; empty = ideal depth
  std::vector<std::string> sensor_names;
  std::filesystem::path model_file;                            // written at the end, atomically
  std::filesystem::path checkpoint;                            // empty = none
  bool resume = false;                                         // continue from the checkpoint
  std::function<bool(const CompletionProgress&)> on_progress;  // false = stop after a checkpoint
};

struct CompletionReport {
  bool finished = false;        // false: stopped on request
  bool has_checkpoint = false;  // the training can be resumed
  bool stopped_early = false;   // held-out views did not improve any more
  int steps = 0;
  std::vector<double> loss_history;
  std::vector<CompletionMeasurement> measurements;
  double seconds = 0;
};

// Trains and writes the model file. Without max_minutes, the same seed and options give the same
// bytes on the CPU, also after stops and resumes. Throws InputError for a checkpoint of other
// options, and if the training diverges.
CompletionReport TrainCompletion(const CompletionJob& job,
                                 const CompletionTrainingOptions& options);

// State of an interrupted training.
struct CompletionCheckpoint {
  std::string key;  // settings; a training with another key cannot resume from it
  int step = 0;
  double seconds = 0;  // trained so far
  std::vector<double> loss_history;
  std::vector<CompletionMeasurement> measurements;
  std::string training_state;
};
void WriteCompletionCheckpoint(const std::filesystem::path& file,
                               const CompletionCheckpoint& checkpoint);
// Throws InputError that names the file if it is missing, damaged or has another key.
CompletionCheckpoint ReadCompletionCheckpoint(const std::filesystem::path& file,
                                              const std::string& key);

}  // namespace pickbed::perception
