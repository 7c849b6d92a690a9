#pragma once

// Trains a descriptor network and its verifiers on views that are rendered during the training. The
// network learns from positive pairs (positive_pairs.h): clutter scenes give query patches, and
// isolated views give codebook patches. Then candidates are found in further clutter scenes of each
// object, and the object's verifier learns which of them are right.
//
// A second thread renders the views while the network trains. Step k uses the first p(k) clutter
// scenes and waits for them. p(k) does not depend on time, except with a time limit. Recall on
// held-out patches is measured during the training (held_out.h). If it reaches a plateau, the
// schedule is shortened.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "perception/candidates/vote_candidates.h"
#include "perception/networks/descriptor_network.h"
#include "perception/networks/losses.h"
#include "perception/training/held_out.h"
#include "perception/training/positive_pairs.h"
#include "perception/training/training_clock.h"
#include "perception/training/verifier_fit.h"
#include "scenes/base/settings.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

struct TrainingOptions {
  uint64_t seed = 0;
  int clutter_scenes = 100;  // per object
  int views_per_scene = 3;   // views per clutter scene
  PositivePairOptions positive_pairs;
  int iterations = 1500;          // training steps per object
  int batch = 160;                // pairs per training step
  double main_share = 0.5;        // share of a batch from one main object; the objects alternate
  double patch_diameters = 0.8;   // patch side over the object's diameter
  double learning_rate = 1.5e-3;  // of Adam; decays to zero along a cosine
  double views_share = 0.75;      // share of the steps after which all clutter scenes are in use
  double rehearsal = 0.1;         // scenes and steps of a rehearsed object, relative to a new one
  // Clutter scenes per object for its verifier. 0 = with verifiers_only, keep the network of the
  // initial model for known backgrounds.
  int verifier_clutter_scenes = 24;
  int verifier_room_scenes = 32;  // rooms per object for its verifier; every second has no object
  // File of a network for unknown backgrounds that gives half of the logit (shared_verifier.h), or
  // "none".
  std::string shared_verifier = "none";
  // The network of `start_from` is kept as it is, and the verifiers of all objects are trained
  // anew.
  bool verifiers_only = false;
  int verifier_entries = 24000;  // codebook entries per object while its verifier is trained
  int checkpoint_every = 200;    // iterations
  double max_minutes = 0;        // limit of the whole training; shortens all of its parts; 0 = none
  NetworkOptions network;
  LossOptions loss;
  VerifierOptions verifier;
  HeldOutOptions held_out;
  // Search options for the candidates of the verifier, for both modes, because mode fast examines
  // fewer rivals. Both modes use candidates.votes.
  CandidateOptions candidates = AccurateCandidates();
  CandidateOptions fast_candidates;
  void Visit(SettingsVisitor& v);
};

// Progress of the current phase.
struct TrainingProgress {
  std::string phase;  // "views", "network", "verifier"
  int done = 0, total = 0;
  double loss = 0;
  double recall_at_1 = -1, recall_at_8 = -1;  // on held-out patches; -1 = not measured yet
  double seconds_left = -1;                   // in this phase; -1 = not known yet
};

// Inputs and outputs of a training.
struct TrainingJob {
  LabelledViewSource& views;         // all of its objects are trained
  std::filesystem::path model_file;  // written at the end, atomically
  std::filesystem::path checkpoint;  // written during the training; empty = none
  bool resume = false;               // continue from the checkpoint
  // Model with the initial weights; empty = none. If it knows some of the objects but not all, the
  // known ones are rehearsed, so that they are not forgotten, and keep their verifiers.
  std::filesystem::path start_from;
  std::string sensor_profile;                                // recorded in the model file
  std::function<bool(const TrainingProgress&)> on_progress;  // false = stop after a checkpoint
  // Begin of the time that max_minutes limits; empty = the call of TrainDescriptor(). A caller that
  // has prepared the views for some time gives its own start.
  std::optional<TrainingTime> began = {};
  TrainingClock now = std::chrono::steady_clock::now;  // a test replaces it
};

// Result of a training.
struct TrainingReport {
  bool finished = false;        // false: stopped on request
  bool has_checkpoint = false;  // the training can be resumed
  // What the checkpoint keeps. A stopped training of a verifier begins anew.
  int kept_steps = 0;      // of the network
  int kept_verifiers = 0;  // of `new_objects`
  int new_objects = 0;     // objects whose verifiers are trained
  std::vector<double> loss_history;
  std::vector<HeldOutRecall> recall_history;  // first before any step, last at the end
  int plateau_iteration = -1;                 // step of the plateau; -1 = none
  std::vector<uint8_t> rehearsed;             // by object: 1 = start_from knows it
  std::vector<double> object_auc;             // by object: area under the verifier's ROC curve
  double verifier_auc = 0;                    // mean over the objects
  double seconds = 0;
  struct PhaseSeconds {
    std::string name;
    double seconds = 0;
  };
  std::vector<PhaseSeconds> phases;  // in order of first appearance

  // For display, filled if finished: held-out queries with their answers, and some of the training
  // pairs by object.
  HeldOutSet held_out;
  std::vector<HeldOutAnswer> answers;
  std::vector<PatchPairs> pairs;
  PatchChannels channels = PatchChannels::kDepthNormals;  // channels of these patches
};

struct VerifierTrainingOptions;
// Returns the options of the verifiers in a training of a descriptor model.
VerifierTrainingOptions VerifierOptionsOf(const TrainingOptions& options);

// Trains network and verifiers and writes the model file. Without max_minutes, the same seed and
// options give the same weights, also after stops and resumes. Throws InputError for a checkpoint
// with other options or objects, and if the training diverges.
TrainingReport TrainDescriptor(const TrainingJob& job, const TrainingOptions& options);

}  // namespace pickbed::perception
