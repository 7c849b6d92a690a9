#pragma once

// Trains the verifiers of an estimator without descriptor model, one object after the other, into
// one file. If a network finds its candidates, the network is trained first, for all objects at
// once. Unfinished results are in a second file, so an existing file is replaced only at the end.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "perception/candidates/candidate_source.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/verifier_training.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

// Inputs and outputs of a training.
struct VerifierJob {
  LabelledViewSource& views;  // all of its objects are trained
  std::string estimator;      // recorded in the file
  std::function<std::unique_ptr<CandidateSource>(const ObjectSet& objects,
                                                 const LearnedNetwork& network)>
      candidates;
  std::filesystem::path file;
  bool resume = false;  // continue from UnfinishedLibrary(file), or add objects to the file
  std::string sensor_profile;
  std::function<bool(std::string_view object, double share)> on_progress;  // false = stop
  // Trains the network, unless the file contains it. Returns nothing if stopped. Empty = no
  // network.
  std::function<std::optional<LearnedNetwork>(const std::function<bool(double share)>& on_share)>
      learn = {};
  std::string network_settings = {};  // settings that `learn` records
  // Checkpoint from which `learn` resumes the training of the network; empty = none.
  std::filesystem::path checkpoint = {};
};

// Result of a training.
struct VerifierReport {
  bool finished = false;  // false: stopped on request
  // File with the finished objects or network, from which a training resumes; empty = none.
  std::filesystem::path saved;
  int saved_objects = 0;  // objects in that file whose verifiers are finished
  double mean_auc = 0;    // mean over the objects in the file, on held-out poses
};

// Returns the path of the file with unfinished results.
std::filesystem::path UnfinishedLibrary(const std::filesystem::path& file);

// Returns all settings that verifiers depend on, besides their objects, as recorded in the file.
std::string VerifierTrainingText(const LabelledViewSource& views, VerifierTrainingOptions options);

// Throws InputError naming the object for errors of TrainObjectVerifier. Throws InputError naming
// the file if it is resumed with other settings, sensor, clutter scenes or network settings.
VerifierReport TrainVerifierLibrary(const VerifierJob& job, const VerifierTrainingOptions& options);

}  // namespace pickbed::perception
