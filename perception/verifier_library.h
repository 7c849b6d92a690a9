#pragma once

// Trains verifiers for an estimator that learns little else, one part after the other, into one
// file. Until all parts are done they are kept in another beside it, so that a file of an earlier
// training stays until then. What its candidates come from is learned before them, of all parts
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
  bool resume = false;  // go on from UnfinishedLibrary(file), or add parts to the file
  std::string sensor_profile;
  std::function<bool(std::string_view part, double share)> on_progress;  // false = stop
  // Learns the network, unless the file holds it; nothing when stopped. Empty = there is none.
  std::function<std::optional<LearnedNetwork>(const std::function<bool(double share)>& on_share)>
      learn = {};
  std::string network_settings = {};  // that `learn` records
  // Of a network half learned, which `learn` goes on from; empty = there is none.
  std::filesystem::path checkpoint = {};
};

struct VerifierReport {
  bool finished = false;  // false: stopped on request
  // What a resumed training goes on from, where parts or the network are done; empty = nothing.
  std::filesystem::path saved;
  double mean_auc = 0;  // over the parts of the file, on held-out poses
};

// Of a file of verifiers whose parts are not all done.
std::filesystem::path UnfinishedLibrary(const std::filesystem::path& file);

// All that verifiers depend on besides their parts, as recorded in the file.
std::string VerifierTrainingText(const LabelledViewSource& views, VerifierTrainingOptions options);

// Throws InputError naming the part as TrainPartVerifier does, and naming the file when it is to be
// resumed but was trained with other settings, sensor or piles.
VerifierReport TrainVerifierLibrary(const VerifierJob& job, const VerifierTrainingOptions& options);

}  // namespace pickbed
