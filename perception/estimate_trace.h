#pragma once

// What an estimator that votes did on its way to an answer, stage by stage, for people who want to
// see why. It holds what was seen and believed, never the truth.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/depth_to_cloud.h"
#include "perception/patch.h"
#include "perception/pose_hypothesis.h"
#include "perception/verify.h"
#include "perception/votes.h"

namespace pickbed {

struct TracedPatch {
  int pixel = 0;  // of its middle, row by row
  double side_m = 0;
  Pose X_CP = Pose::Identity();
  std::array<int8_t, kPatchValues> values{};  // see patch.h
};

// The pose of the code book's entry in the patch's frame is X_CP^-1 * vote.X_CO.
struct TracedVote {
  int patch = 0;  // index into EstimateTrace::patches
  RawHypothesis vote;
  float distance = 0;  // of the descriptors
};

// A pose before and after ICP. Quick scores: before, its rank among the votes; after, in the fine
// gate.
struct TracedRefinement {
  RawHypothesis before, after;
  bool look_alike = false;  // a turned pose that was refined, no vote
};

struct TracedCandidate {
  PoseHypothesis hypothesis;  // score as in the final set, see CandidateScore
  VerifyFeatures features{};
};

struct EstimateTrace {
  OrganizedCloud cloud;
  int neighbors = 0;                // votes of a patch, where the code book has as many
  double min_score = 0;             // below it a candidate is not reported
  std::vector<int> instances = {};  // what the estimator was told of them (EstimatorInput)
  PatchChannels channels = PatchChannels::kDepthNormals;  // of the patches
  std::vector<TracedPatch> patches;           // a frame's pixels, once for each patch side
  std::vector<TracedVote> votes;              // those of a patch stand together, nearest first
  std::vector<TracedRefinement> refinements;  // of the votes that were selected, and look-alikes
  std::vector<TracedCandidate> candidates;    // X_CO is the `after` of one of the refinements
  std::vector<PoseHypothesis> accepted;       // of the candidates, before the final refiner
};

// Appends the patches around `pixels` and returns the index of the first.
int TracePatches(std::span<const int> pixels, const PatchSet& patches, double side_m,
                 EstimateTrace& trace);

}  // namespace pickbed
