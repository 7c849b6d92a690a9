#pragma once

// Trace of an estimator that votes: the intermediate results of each stage, for display and
// diagnosis. It holds only observed and estimated data, never ground truth.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/cloud/organized_cloud.h"
#include "perception/features/patch.h"
#include "perception/pose_hypothesis.h"
#include "perception/verify/pose_features.h"
#include "perception/voting/pose_clustering.h"

namespace pickbed::perception {

// A patch cut from the cloud.
struct TracedPatch {
  int pixel = 0;  // index of the center pixel, row by row
  double side_m = 0;
  Pose X_CP = Pose::Identity();
  std::array<int8_t, kPatchValues> values{};  // see patch.h
};

// A vote of one patch. The pose of the codebook entry in the patch frame is X_CP^-1 * vote.X_CO.
struct TracedVote {
  int patch = 0;  // index into EstimateTrace::patches
  RawHypothesis vote;
  float distance = 0;  // descriptor distance; 0 for a regressed pose
};

// A pose before and after ICP. The quick score of `before` is its rank among the votes; the quick
// score of `after` uses the final correspondence distance as band.
struct TracedRefinement {
  RawHypothesis before, after;
  bool ambiguous_pose = false;  // starts from an ambiguous pose, not from a vote
};

// A scored candidate.
struct TracedCandidate {
  PoseHypothesis hypothesis;  // score as in the pose selection, see CandidateScore
  VerifyFeatures features{};
};

// Intermediate results of one estimate, in the order of the stages.
struct EstimateTrace {
  OrganizedCloud cloud;
  int neighbors = 0;                // codebook votes per patch, at most
  double min_score = 0;             // candidates with a lower score are not reported
  std::vector<int> instances = {};  // number of instances given to the estimator (EstimatorInput)
  PatchChannels channels = PatchChannels::kDepthNormals;
  std::vector<TracedPatch> patches;           // each sampled pixel once per patch side
  std::vector<TracedVote> votes;              // grouped by patch; codebook votes nearest first
  std::vector<TracedRefinement> refinements;  // of selected votes and of ambiguous poses
  std::vector<TracedCandidate> candidates;    // X_CO is the `after` of one of the refinements
  std::vector<PoseHypothesis> accepted;       // reported candidates, before the final refiner
};

// Appends the patches cut around `pixels` and returns the index of the first one.
int TracePatches(std::span<const int> pixels, const PatchSet& patches, double side_m,
                 EstimateTrace& trace);

}  // namespace pickbed::perception
