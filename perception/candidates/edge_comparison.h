#pragma once

// Comparison of the poses of one instance that have nearly the same depth image, by the brightness
// edges of the image. The verifier gives these poses similar scores.

#include <span>
#include <vector>

#include "perception/candidates/candidate_comparison.h"

namespace pickbed::perception {

// Changes the scores of candidates that are different poses of one object with nearly the same
// surface. Their sum is the probability that one of them is right. It stays, or becomes 1 if it is
// larger, and the edges divide it. A pose whose mean edge support is a fraction f below the best
// one with about as many visible edge points is exp(kEdgeWeight * f) times less likely, at most
// exp(kMaxEdgeNats) times. Scores of other candidates stay, and all scores stay without a color
// image.
// - models, distances: by object index
// - scores: one per candidate, 0 .. 1
void WeighByEdges(const OrganizedCloud& cloud, const std::vector<ModelPoints>& models,
                  const std::vector<PoseDistance>& distances,
                  const std::vector<Candidate>& candidates, std::span<double> scores);

inline constexpr double kEdgeWeight = 60;
inline constexpr double kMaxEdgeNats = 6;

}  // namespace pickbed::perception
