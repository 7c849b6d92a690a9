#pragma once

// Estimator with the whole-object descriptor of Wohlhart and Lepetit (networks/wohlhart.h). Crops
// around a grid of visible points (whole_crops.h) vote for the poses of their nearest templates.
// Clustering, ICP, verifier and pose selection are the same as for estimator descriptor. Templates
// cover all directions and in-plane angles.

#include <memory>

#include "perception/candidates/candidate_refinement.h"
#include "perception/crops/whole_crops.h"
#include "perception/estimators/estimator_training.h"
#include "perception/estimators/pose_estimator.h"
#include "perception/networks/verifier_file.h"
#include "perception/networks/wohlhart.h"

namespace pickbed::perception {

// Options that are stored with the trained network.
struct WohlhartBinOptions {
  WholeViewOptions views;
  // - pair_weight: with a single object, a pair term of full weight contracts all descriptors to
  //   one point.
  // - occluded_share: lower than the default, because clutter scenes already contain occlusion.
  // - depth_reach: the reference depth is a surface point, and the whole object may be behind it.
  WohlhartOptions network{.input = "depth",
                          .depth_reach = 1,
                          .pair_weight = 0.1,
                          .iterations = 1000,
                          .augment = {.occluded_share = 0.4}};
  int grid_px = 8;    // distance of neighbouring proposals along rows and columns
  int neighbors = 4;  // votes per crop: number of nearest templates
  void Visit(SettingsVisitor& v);
};

// Makes the candidate source for objects that `network` was trained for. `views` renders their
// templates and must have objects with the same names. Times are added under "crops", "network" and
// the names of CandidateRefiner. It draws no random numbers. Throws InputError for other objects
// or settings.
std::unique_ptr<CandidateSource> MakeWohlhartCandidates(
    const ObjectSet& objects, LabelledViewSource& views, const LearnedNetwork& network,
    const CandidateRefinementOptions& refinement, int threads = 1);

// Returns the training with these network options. NetworkSettings() are the names and mesh hashes
// of the objects and the options. MakeCandidates() uses the options of AccurateCandidates().
// TrainNetwork() throws InputError if the network's input is not depth.
std::unique_ptr<EstimatorTraining> MakeWohlhartTraining(const WohlhartBinOptions& options);

// Entries of EstimatorTable(). The default model is wohlhart.net. The modes select the candidate
// refinement, as for estimator descriptor. Throws InputError as LoadVerifiers and TrainedObjects
// do, and if setup.views is null.
std::unique_ptr<PoseEstimator> MakeWohlhartEstimator(const EstimatorSetup& setup);
// Returns the training with the default options.
std::unique_ptr<EstimatorTraining> MakeWohlhartTraining();

}  // namespace pickbed::perception
