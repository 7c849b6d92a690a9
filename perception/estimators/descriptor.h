#pragma once

// The learned estimators: patches described by a network vote through a code book, ICP refines the
// votes and a learned verifier ranks them. After Wohlhart and Lepetit 2015 and Kehl et al. 2016.

#include <filesystem>
#include <memory>
#include <string>

#include "perception/candidates.h"
#include "perception/final_set.h"
#include "perception/polish.h"
#include "perception/pose_estimator.h"

namespace pickbed {

struct DescriptorOptions {
  int code_entries = 40000;           // of each part
  int code_patches_per_view = 10;     // of an isolated view
  double code_distance_spread = 0.1;  // relative, about the working distance
  uint64_t code_seed = 0;
  CandidateOptions candidates;
  FinalSetOptions final_set;  // its least score is the setup's
  PolishOptions polish;
  void Visit(SettingsVisitor& v);
};

// fast: 600 points, 300 candidates, one ICP gate, few look-alikes. hard: 1,200 points, 600
// candidates, two gates, more look-alikes.
// Throws InputError for another mode.
DescriptorOptions OptionsForMode(const std::string& mode);

// spec.model as a file, or as a name under assets/models; empty = the shipped one.
std::filesystem::path DescriptorModelFile(const EstimatorSpec& spec);

// Loads the model and makes or reads the code books. Throws InputError as LoadModel and
// TrainedParts do, and when setup.views is null.
std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup,
                                                       const DescriptorOptions& options);

// The same with the model of another method: `kind` is that of its network, `command` trains it.
// Throws InputError also for a model of another kind.
struct LearnedModel {
  std::filesystem::path file;
  std::string kind;     // empty = any
  std::string command;  //
  // Whose regressed poses are voted for besides, where candidates.votes is both and `file` does not
  // regress; its patches must be of the same sides. Empty = none.
  std::filesystem::path regression = {};
};
std::unique_ptr<PoseEstimator> MakeLearnedEstimator(const EstimatorSetup& setup,
                                                    const DescriptorOptions& options,
                                                    const LearnedModel& model);

// Row of the table: options by setup.spec.mode.
std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
