#pragma once

// Trains the descriptor network and its verifier on views rendered on the fly: piles give the
// patches that a query will show, isolated views their twins as the code book will hold them; twins
// are pulled together and patches of other poses apart. Then the estimator's own front part runs on
// further piles of each part, and the part's verifier learns which of its candidates are right.
//
// Views are made in a thread of their own while the network learns from those that are there: step
// k learns from the first p(k) piles, a number that follows from the settings alone, and waits for
// them. On the way recall on held-out patches is measured (held_out.h); where it stays on a plateau
// the schedule is cut short.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "perception/candidates.h"
#include "perception/held_out.h"
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
  double views_share = 0.75;      // of the steps, by which all piles are in
  double rehearsal = 0.1;         // piles and steps of a part that start_from knows, over another's
  int verifier_piles = 24;        // per object
  int verifier_entries = 24000;   // code book entries per object while it learns
  int checkpoint_every = 200;     // iterations
  double max_minutes = 0;         // of views and network; 0 = no limit. The schedule follows it
  NetworkOptions network;
  LossOptions loss;
  VerifierOptions verifier;
  HeldOutOptions held_out;
  // How the candidates are found that the verifier learns on: those of both modes, since in the
  // fast one fewer rivals are looked at. The votes are those of the first.
  CandidateOptions candidates = HardCandidates();
  CandidateOptions fast_candidates;
  void Visit(SettingsVisitor& v);
};

struct TrainingProgress {
  std::string phase;  // "views", "network", "verifier"
  int done = 0, total = 0;
  double loss = 0;
  double recall_at_1 = -1, recall_at_8 = -1;  // on held-out patches; -1 = not measured yet
  double seconds_left = -1;                   // of the phase; -1 = not known yet
};

struct TrainingJob {
  LabelledViewSource& views;         // its objects are what is learned
  std::filesystem::path model_file;  // written at the end, atomically
  std::filesystem::path checkpoint;  // written on the way; read when `resume`; empty = none
  bool resume = false;
  // A model whose weights training begins with; empty = none. Where it knows some of the parts but
  // not all, those are rehearsed, so that they are not forgotten, and keep their verifiers.
  std::filesystem::path start_from;
  std::string sensor_profile;                                // recorded in the model file
  std::function<bool(const TrainingProgress&)> on_progress;  // false = stop after a checkpoint
};

struct TrainingReport {
  bool finished = false;        // false: stopped on request
  bool has_checkpoint = false;  // there is something to resume from
  std::vector<double> loss_history;
  std::vector<HeldOutRecall> recall_history;  // first before any step, last at the end
  int plateau_iteration = -1;                 // where the schedule was cut short; -1 = nowhere
  std::vector<uint8_t> rehearsed;             // by part: 1 = start_from knew it
  std::vector<double> part_auc;               // of the verifiers, by part
  double verifier_auc = 0;                    // mean over parts
  double seconds = 0;
  struct PhaseSeconds {
    std::string name;
    double seconds = 0;
  };
  std::vector<PhaseSeconds> phases;  // each kind of work, in order of appearance

  // Filled when finished, for pictures: held-out queries with what was found, and some of the
  // pairs that were learned from, by part.
  HeldOutSet held_out;
  std::vector<HeldOutAnswer> answers;
  std::vector<PatchPairs> pairs;
  PatchChannels channels = PatchChannels::kDepthNormals;  // of all these patches
};

// The same seed and options give the same weights (without max_minutes), also after any number of
// stops and resumes. Throws InputError for a checkpoint of other options or parts.
TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options);

}  // namespace pickbed
