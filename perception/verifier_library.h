#pragma once

// Trains verifiers for an estimator that learns little else, one part after the other, into one
// file that is whole after each. What its candidates come from is learned before them, of all parts
// at once.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "perception/candidate_source.h"
#include "perception/torch_verifier_file.h"
#include "perception/verifier_training.h"
#include "scenes/labelled_view.h"

namespace pickbed {

struct VerifierJob {
  LabelledViewSource& views;  // its objects are what is learned
  std::string estimator;      // recorded in the file
  std::function<std::unique_ptr<CandidateSource>(const ObjectSet& objects,
                                                 const LearnedNetwork& network)>
      candidates;
  std::filesystem::path file;
  bool resume = false;  // keep what the file holds of these parts, where it does
  std::string sensor_profile;
  std::function<bool(std::string_view part, double share)> on_progress;  // false = stop
  // Learns the network, unless the file holds it; nothing when stopped. Empty = there is none.
  std::function<std::optional<LearnedNetwork>(const std::function<bool(double share)>& on_share)>
      learn = {};
  std::string network_settings = {};  // that `learn` records
};

struct VerifierReport {
  bool finished = false;  // false: stopped on request
  bool is_saved = false;  // the file holds the parts done by then, or the network at least
  double mean_auc = 0;    // over the parts of the file, on held-out poses
};

// All that verifiers depend on besides their parts, as recorded in the file.
std::string VerifierTrainingText(const LabelledViewSource& views, VerifierTrainingOptions options);

// Throws InputError naming the part as TrainPartVerifier does, and naming the file when it is to be
// resumed but was trained with other settings, sensor or piles.
VerifierReport TrainVerifierLibrary(const VerifierJob& job, const VerifierTrainingOptions& options);

}  // namespace pickbed
