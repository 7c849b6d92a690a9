#pragma once

// The pairs of patches that a descriptor network learns from, held in memory, and the batches drawn
// from them. Piles come in one by one while the network learns.

#include <vector>

#include "perception/pose_embedding.h"
#include "perception/pose_targets.h"
#include "perception/training.h"
#include "perception/twin_patches.h"

namespace pickbed {

class TrainingData {
 public:
  // No pairs yet; main_parts: the part that each step's batch is mostly of.
  // sides_m: patch side by part; targets: batches tell poses, for a network that regresses.
  TrainingData(const ObjectSet& objects, std::vector<int> main_parts,
               const std::vector<double>& sides_m, bool targets, const TrainingOptions& options);

  // The next pile's pairs, by part.
  void Add(const std::vector<PatchPairs>& pile);
  int piles() const { return piles_; }

  // Throws InputError naming a part of which there are no pairs.
  void RequireAllParts() const;

  // Depends on seed, iteration and the piles that are in; of the parts that they show. Throws
  // InputError when they show none.
  TrainingBatch Batch(int iteration) const;

  const std::vector<PatchPairs>& pairs() const { return parts_; }  // by part

 private:
  struct Choice {
    int part = 0;
    int pair = 0;
  };
  std::vector<Choice> Choose(int iteration) const;
  void FillDistances(const std::vector<Choice>& choices, TrainingBatch& batch) const;
  void FillTargets(const std::vector<Choice>& choices, TrainingBatch& batch) const;

  const ObjectSet& objects_;
  std::vector<int> main_parts_;
  TrainingOptions options_;
  int piles_ = 0;
  std::vector<PatchPairs> parts_;
  std::vector<PoseEmbedding> embeddings_;
  std::vector<PoseTargets> targets_;  // empty: not wanted
  int variants_ = 0;                  // most of any part
};

}  // namespace pickbed
