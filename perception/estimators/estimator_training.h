#pragma once

// Training interface of an estimator: its model file, and what `pickbed train NAME` trains.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "perception/candidates/candidate_source.h"
#include "perception/networks/verifier_file.h"
#include "perception/training/training.h"
#include "scenes/labelled_view.h"
#include "scenes/scenario/scenario_spec.h"

namespace pickbed::perception {

// What is trained for an estimator.
enum class TrainingKind {
  kNone,                 // nothing: its model is trained for another estimator
  kPatchNetwork,         // a patch network with its verifiers, by TrainDescriptor()
  kVerifiers,            // only verifiers, by TrainVerifierLibrary()
  kNetworkAndVerifiers,  // first the network that finds the candidates, then verifiers
};

// Inputs for making a candidate source.
struct CandidateSetup {
  const ObjectSet& objects;
  LabelledViewSource& views;  // of these objects; may have others
  const LearnedNetwork& network;
};

// Inputs for training the network of a candidate source.
struct NetworkTrainingJob {
  LabelledViewSource& views;  // all of its objects are trained
  uint64_t seed = 0;
  std::filesystem::path checkpoint;            // see WohlhartJob
  std::function<bool(double share)> on_share;  // progress, 0..1; false = stop; may be empty
  int threads = 1;                             // the result does not depend on it
};

// Training of one estimator. The functions for another kind of training throw std::logic_error.
class EstimatorTraining {
 public:
  virtual ~EstimatorTraining() = default;

  virtual TrainingKind kind() const = 0;
  // Returns the model file that the estimator reads, even if it does not exist. Empty: it reads
  // none in this mode.
  virtual std::filesystem::path ModelFile(const EstimatorSpec& spec) const = 0;

  // kPatchNetwork: returns the default options.
  virtual TrainingOptions PatchNetworkOptions() const;

  // kVerifiers, kNetworkAndVerifiers: makes the candidates that the verifiers are trained on.
  virtual std::unique_ptr<CandidateSource> MakeCandidates(const CandidateSetup& setup) const;

  // kNetworkAndVerifiers: visits the options of the network.
  virtual void VisitNetworkOptions(SettingsVisitor& v);
  // kNetworkAndVerifiers: returns the settings that are recorded with a network for these objects.
  virtual std::string NetworkSettings(const ObjectSet& objects) const;
  // kNetworkAndVerifiers: trains the network; returns nothing if stopped.
  virtual std::optional<LearnedNetwork> TrainNetwork(const NetworkTrainingJob& job) const;

  // Whether the verifiers are in a file without a patch network.
  bool has_verifier_file() const {
    return kind() == TrainingKind::kVerifiers || kind() == TrainingKind::kNetworkAndVerifiers;
  }
};

// Returns the model file: spec.model is a path or a name under assets/models; if it is empty,
// `default_model` is the name.
std::filesystem::path ModelFileOr(const EstimatorSpec& spec, const char* default_model);

// Returns the training of an estimator with a patch network.
std::unique_ptr<EstimatorTraining> MakePatchNetworkTraining(const char* default_model,
                                                            const TrainingOptions& options);

}  // namespace pickbed::perception
