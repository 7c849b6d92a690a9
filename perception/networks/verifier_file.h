#pragma once

// File of verifiers for an estimator that has no descriptor model. The verifiers score the
// candidates of this estimator. If a trained network finds the candidates, the file contains it.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "perception/networks/model_file.h"
#include "perception/verify/pose_features.h"

namespace pickbed::perception {

// A network that finds candidates, in the form that its estimator reads.
struct LearnedNetwork {
  std::string settings;  // empty = no network
  std::vector<float> weights;
};

// Content of a verifier file.
struct VerifierFile {
  std::string estimator;             // estimator whose candidates they score
  std::string sensor;                // sensor profile of the training views
  std::string training;              // effective settings; files with equal ones are comparable
  std::vector<ModelObject> objects;  // side_m is unused
  std::vector<Verifier> verifiers;   // one per object
  LearnedNetwork network;
};

// Writes the file atomically.
void SaveVerifiers(const std::filesystem::path& file, const VerifierFile& content);

// Throws InputError naming the file if it is absent, damaged, no verifier file, of an unsupported
// version, or made for another estimator.
VerifierFile LoadVerifiers(const std::filesystem::path& file, const std::string& estimator);

// Returns the verifiers as plain numbers, one after the other, as stored in model files. All get as
// many hidden units as the largest network.
std::vector<float> VerifierValues(const std::vector<Verifier>& verifiers);

// Shape of stored verifiers: the number of leading features that they use, the number of
// calibrations (one per mode, or one for all modes), and whether there is a network for unknown
// backgrounds.
struct VerifierLayout {
  int features = kVerifyFeatures;
  int calibrations = kCandidateModes;
  bool has_unknown = true;
};
// Layouts of older files: without the features for bin, floor and neighbours; without the outline
// feature; without one calibration per mode; without the support features; without the network for
// unknown backgrounds.
inline constexpr VerifierLayout kWithoutSurroundings{16, 1, false}, kWithoutOutline{19, 1, false},
    kOneCalibration{20, 1, false}, kWithoutSupport{20, kCandidateModes, false},
    kWithoutUnknown{24, kCandidateModes, false};

// Returns `count` verifiers of equal shape. Features beyond the layout get zero weight. Without a
// network for unknown backgrounds, the other network and its calibrations are used for them. Throws
// InputError if the number of values does not fit.
std::vector<Verifier> VerifiersFrom(const std::vector<float>& values, size_t count,
                                    const VerifierLayout& layout = {});

}  // namespace pickbed::perception
