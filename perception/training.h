#pragma once

// Trains the descriptor network and its verifier on views rendered on the fly: piles give the
// patches that a query will show, isolated views their twins as the code book will hold them; twins
// are pulled together and patches of other poses apart. Then the estimator's own front part runs on
// further piles of each part, and the part's verifier learns which of its candidates are right.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perception/candidates.h"
#include "perception/torch_losses.h"
#include "perception/torch_network.h"
#include "perception/torch_verifier.h"
#include "perception/twin_patches.h"
#include "scenes/labelled_view.h"
#include "scenes/settings.h"

namespace pickbed {

struct TrainingOptions {
  uint64_t seed = 0;
  int piles = 100;                // per object
  int views_per_pile = 3;         //
  TwinOptions twins;              // the pairs of patches to learn from
  int iterations = 1500;          // per object
  int batch = 160;                // pairs of patches
  double main_share = 0.5;        // share of a batch that is of one part, the parts taking turns
  double patch_diameters = 0.8;   // side of a patch over the part's diameter
  double learning_rate = 1.5e-3;  // of Adam, falls to zero along a cosine
  int verifier_piles = 24;        // per object
  int verifier_entries = 24000;   // code book entries per object while it learns
  int checkpoint_every = 200;     // iterations
  double max_minutes = 0;         // of views and network; 0 = no limit. The schedule follows it
  NetworkOptions network;
  LossOptions loss;
  VerifierOptions verifier;
  // How the candidates are found that the verifier learns on.
  CandidateOptions candidates = HardCandidates();
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
  std::filesystem::path start_from;  // a model whose weights training begins with; empty = none
  std::string sensor_profile;        // recorded in the model file
  std::function<bool(const TrainingProgress&)> on_progress;  // false = stop after a checkpoint
};

struct TrainingReport {
  bool finished = false;  // false: stopped on request, checkpoint written
  std::vector<double> loss_history;
  double verifier_auc = 0;  // mean over parts
  double seconds = 0;
};

// The same seed and options give the same weights (without max_minutes), also after any number of
// stops and resumes. Throws InputError for a checkpoint of other options or parts.
TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options);

}  // namespace pickbed
