#pragma once

// Estimators with a learned patch network: patches vote for poses through a codebook, ICP refines
// the poses, and a learned verifier scores them. Based on Wohlhart and Lepetit 2015 and Kehl et al.
// 2016.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "perception/candidates/pose_selection.h"
#include "perception/candidates/vote_candidates.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/icp/final_refinement.h"

namespace pickbed::perception {

inline constexpr const char* kShippedModel = "shipped";
inline constexpr const char* kFirstMode = "first";

struct DescriptorOptions {
  int code_entries = 40000;           // codebook entries per object
  int code_patches_per_view = 10;     // patches per isolated view of the codebook
  double code_distance_spread = 0.1;  // distances are working distance * (1 -+ spread)
  uint64_t code_seed = 0;
  CandidateOptions candidates;
  PoseSelectionOptions pose_selection;  // min_score is replaced by spec.min_score of the setup
  std::optional<FirstPosesSpec> first;  // set: a few sure poses, see first_poses.h
  // Visits all options except `pose_selection` and `first`.
  void Visit(SettingsVisitor& v);
};

// Returns the options of a mode. "fast": 600 points, 300 candidates, one correspondence distance,
// few ambiguous poses. "accurate": 1,200 points, 600 candidates, two distances, more ambiguous
// poses, two rounds in all scenes. "first": like "fast", but with one round in each region; the
// estimator sets `first`. Throws InputError for another mode.
DescriptorOptions OptionsForMode(const std::string& mode);

// Loads the model (spec.model, see ModelFileOr(); empty = the shipped one), and makes the codebooks
// or reads them from the cache. Throws InputError as LoadModel and TrainedObjects do, and if
// setup.views is null.
std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup,
                                                       const DescriptorOptions& options);

// Model of a learned estimator.
struct LearnedModel {
  std::filesystem::path file;
  std::string kind;     // required kind of the network; empty = any
  std::string command;  // command that trains the model, for error messages
  // Second model, whose network regresses the poses if candidates.votes is "both". It must have the
  // same patch sides and channels. Empty = none.
  std::filesystem::path regression = {};
};
// The same for the model of another method. Throws InputError also for another kind of network, and
// if the second model does not fit.
std::unique_ptr<PoseEstimator> MakeLearnedEstimator(const EstimatorSetup& setup,
                                                    const DescriptorOptions& options,
                                                    const LearnedModel& model);

// Entries of EstimatorTable(). The options depend on setup.spec.mode. The default model is the
// shipped one.
std::unique_ptr<PoseEstimator> MakeDescriptorEstimator(const EstimatorSetup& setup);
// Returns the training of estimator descriptor.
std::unique_ptr<EstimatorTraining> MakeDescriptorTraining();

}  // namespace pickbed::perception
