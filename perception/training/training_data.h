#pragma once

// Training pairs of a descriptor network, in memory, and the batches sampled from them. Clutter
// scenes are added one by one during the training.

#include <vector>

#include "perception/features/pose_targets.h"
#include "perception/model/pose_distance.h"
#include "perception/training/positive_pairs.h"
#include "perception/training/training.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Collects training pairs and makes batches.
class TrainingData {
 public:
  // Starts without pairs.
  // - main_objects: main object of each step's batch, see TrainingOptions::main_share
  // - sides_m: patch side by object
  // - targets: batches contain poses, for a network that regresses
  TrainingData(const ObjectSet& objects, std::vector<ObjectId> main_objects,
               const std::vector<double>& sides_m, bool targets, const TrainingOptions& options);

  // Adds the pairs of one clutter scene; `clutter_scene` is by object.
  void Add(const std::vector<PatchPairs>& clutter_scene);
  int clutter_scenes() const { return clutter_scenes_; }

  // Throws InputError naming the object if an object has no pairs.
  void RequireAllObjects() const;

  // Returns the batch of a step, with the objects that have pairs. It depends on seed, iteration
  // and the scenes added so far. Throws InputError if no object has pairs.
  TrainingBatch Batch(int iteration) const;

  const std::vector<PatchPairs>& pairs() const { return pairs_; }  // by object

 private:
  struct Choice {
    ObjectId object{0};
    int pair = 0;
  };
  std::vector<Choice> Choose(int iteration) const;
  void FillDistances(const std::vector<Choice>& choices, TrainingBatch& batch) const;
  void FillTargets(const std::vector<Choice>& choices, TrainingBatch& batch) const;

  const ObjectSet& objects_;
  std::vector<ObjectId> main_objects_;
  TrainingOptions options_;
  int clutter_scenes_ = 0;
  std::vector<PatchPairs> pairs_;
  std::vector<PoseEmbedding> embeddings_;
  std::vector<PoseTargets> targets_;  // empty if batches contain no poses
  int variants_ = 0;                  // maximum number of symmetric poses of any object
};

}  // namespace pickbed::perception
