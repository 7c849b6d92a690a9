#pragma once

// Trains the descriptor network and its verifier on views rendered on the fly.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "scenes/labelled_view.h"
#include "scenes/settings.h"

namespace pickbed {

struct TrainingOptions {
  uint64_t seed = 0;
  int piles = 60;         // per object; two views each
  int code_views = 3000;  // isolated views per object for positives
  int iterations = 1500;  // per object
  int batch = 160;
  int descriptor = 32;           // length of the descriptor
  double patch_diameters = 0.8;  // side of a patch over the part's diameter
  double margin = 0.01;          // m of PAPERS: Wohlhart and Lepetit 2015, eq. 2
  double learning_rate = 1.5e-3;
  int checkpoint_every = 200;  // iterations
  double max_minutes = 0;      // 0 = no limit; the learning rate's schedule follows it
  void Visit(SettingsVisitor& v);
};

struct TrainingProgress {
  std::string phase;  // "views", "network", "verifier"
  int done = 0, total = 0;
  double loss = 0;
  double seconds_left = 0;
};

struct TrainingJob {
  LabelledViewSource& views;         // its objects are what is learned
  std::filesystem::path model_file;  // written at the end, atomically
  std::filesystem::path checkpoint;  // written on the way; read when `resume`
  bool resume = false;
  std::string sensor_profile;                                // recorded in the model file
  std::function<bool(const TrainingProgress&)> on_progress;  // false = stop after a checkpoint
};

struct TrainingReport {
  bool finished = false;  // false: stopped on request, checkpoint written
  std::vector<double> loss_history;
  double verifier_auc = 0;
  double seconds = 0;
};

TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options);

}  // namespace pickbed
