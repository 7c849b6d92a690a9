#pragma once

// The whole-object descriptor of Wohlhart and Lepetit (networks/wohlhart.cpp) in bins: crops around
// a grid of visible points (whole_crops.h), each of which votes for the poses of its nearest
// templates; clustering, ICP, verifier and final set are those of `descriptor`. Templates stand all
// around and at all turns, so the network learns with the dynamic margin of Zakharov et al. 2017.

#include <filesystem>
#include <memory>
#include <optional>

#include "perception/assessment.h"
#include "perception/networks/wohlhart.h"
#include "perception/pose_estimator.h"
#include "perception/torch_verifier_file.h"
#include "perception/whole_crops.h"

namespace pickbed {

struct WohlhartBinOptions {
  WholeViewOptions views;
  // Of one part alone a pair term of full weight draws all descriptors together to a point.
  // Piles hide enough of their parts themselves, so that fewer crops get something before them.
  // Crops stand for the depth of a point of the surface, behind which all of the part may lie.
  WohlhartOptions network{.input = "depth",
                          .depth_reach = 1,
                          .pair_weight = 0.1,
                          .iterations = 1000,
                          .augment = {.occluded_share = 0.4}};
  int grid_px = 8;    // between two proposals, both ways
  int neighbors = 4;  // votes of a crop: k of the look-up
  void Visit(SettingsVisitor& v);
};

// The candidates of these parts, which `network` was learned for. `views` renders their templates
// and holds them under the same names. Seconds are added under "crops" and "network", and those of
// CandidateAssessor. Draws no random numbers. Throws InputError for other parts and settings.
std::unique_ptr<CandidateSource> MakeWohlhartCandidates(const ObjectSet& objects,
                                                        LabelledViewSource& views,
                                                        const LearnedNetwork& network,
                                                        const AssessmentOptions& assessment,
                                                        int threads = 1);
// Of the table: with the assessment of mode hard.
std::unique_ptr<CandidateSource> MakeWohlhartCandidates(const CandidateSetup& setup);

// What LearnWohlhart() records of a network: its parts with their meshes, and settings.
std::string WohlhartSettings(const ObjectSet& objects, const WohlhartBinOptions& options);

// Learns all parts of the views; nothing when stopped.
std::optional<LearnedNetwork> LearnWohlhart(const LearnJob& job);

// spec.model as a file, or as a name under assets/models; empty = wohlhart.pt there.
std::filesystem::path WohlhartModelFile(const EstimatorSpec& spec);

// Modes fast and hard: how thorough candidates are assessed, as in descriptor. Throws InputError as
// LoadVerifiers and TrainedParts do, and when setup.views is null.
std::unique_ptr<PoseEstimator> MakeWohlhartEstimator(const EstimatorSetup& setup);

}  // namespace pickbed
