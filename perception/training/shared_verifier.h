#pragma once

// Trains a verifier network for unknown backgrounds on many objects. The features of a pose
// (pose_features.h) are shares, angles and multiples of the diameter, so they mean the same for
// every object. A dozen rooms show an object in about a hundred right poses, too few for a good
// network of its own. So this network may give half of the logit of an object that is trained later
// (VerifierTrainingOptions::shared_network). docs/pages/benchmarks_rooms.md has measurements.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "perception/training/verifier_training.h"
#include "perception/verify/pose_features.h"
#include "scenes/labelled_view.h"

namespace pickbed::perception {

// Value of the setting shared_verifier for no such network. Other values name a file
// (TrainedFile()).
inline constexpr const char* kNoSharedVerifier = "none";

// Inputs and outputs of a training.
struct SharedVerifierJob {
  LabelledViewSource& views;    // rooms of all of its objects are searched
  std::filesystem::path model;  // descriptor model that knows these objects; finds the candidates
  std::filesystem::path file;   // written at the end, atomically
  bool resume = false;          // continue from UnfinishedSharedVerifier(file)
  std::string sensor_profile;   // recorded in the file
  std::function<bool(std::string_view object, double share)> on_progress;  // false = stop
};

// Result of a training.
struct SharedVerifierReport {
  bool finished = false;  // false: stopped on request
  int objects = 0;        // whose rooms were searched; a resumed training keeps them
  int candidates = 0;     // in these rooms
  int right = 0;          // number of these that are right
};

// Returns the file with the candidates of a stopped training.
std::filesystem::path UnfinishedSharedVerifier(const std::filesystem::path& file);

// Searches rooms of each object for candidates, which takes minutes per object, and trains one
// network on all of them. The rooms differ from the rooms for which TrainObjectVerifier()
// calibrates the network with the same seed. Throws InputError if the model does not know an
// object, if no candidate is right, or if a resumed file is damaged or has other settings.
SharedVerifierReport TrainSharedVerifier(const SharedVerifierJob& job,
                                         const VerifierTrainingOptions& options);

// Writes the file atomically. `settings`: everything that the training depended on, as text.
void SaveSharedVerifier(const std::filesystem::path& file, const VerifierNetwork& network,
                        const std::string& sensor_profile, const std::string& settings);

// Throws InputError naming the file if it is absent, damaged or no shared verifier.
VerifierNetwork LoadSharedVerifier(const std::filesystem::path& file);

}  // namespace pickbed::perception
