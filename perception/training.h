#pragma once

// Trains the descriptor network and its verifier on views rendered on the fly: piles give the
// patches that a query will show, isolated views those that the code book will hold; patches of
// nearly equal pose are pulled together. Then the estimator's own front part runs on further piles
// and the verifier learns which of its candidates are right.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perception/candidates.h"
#include "perception/torch_losses.h"
#include "perception/torch_network.h"
#include "perception/torch_verifier.h"
#include "scenes/labelled_view.h"
#include "scenes/settings.h"

namespace pickbed {

struct TrainingOptions {
  uint64_t seed = 0;
  int piles = 60;                 // per object
  int views_per_pile = 2;         //
  int patches_per_view = 300;     // of a pile
  double min_visible = 0.1;       // visible fraction of an instance to learn from
  int code_views = 3000;          // isolated views per object
  int code_patches = 8;           // per isolated view
  int iterations = 1500;          // per object
  int batch = 160;                // pairs of patches
  int positives = 4;              // an anchor's partner is one of so many pose-nearest code patches
  double main_share = 0.5;        // share of a batch that is of one part, the parts taking turns
  double patch_diameters = 0.8;   // side of a patch over the part's diameter
  double learning_rate = 1.5e-3;  // of Adam, falls to zero along a cosine
  int verifier_piles = 20;        // per object
  int checkpoint_every = 200;     // iterations
  double max_minutes = 0;         // of views and network; 0 = no limit. The schedule follows it
  NetworkOptions network;
  LossOptions loss;
  VerifierOptions verifier;
  CandidateOptions candidates;  // how the candidates are found that the verifier learns on
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
  std::filesystem::path checkpoint;  // written on the way; read when `resume`; empty = none
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

// The same seed and options give the same weights (without max_minutes), also after any number of
// stops and resumes. Throws InputError for a checkpoint of other options or parts.
TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options);

}  // namespace pickbed
