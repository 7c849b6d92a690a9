#pragma once

// Renders all views of a training in a separate thread while the network trains. The order is: the
// held-out set, the clutter scenes, the training set of each verifier. Each item depends only on
// its index, so the result does not depend on time.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "perception/training/held_out.h"
#include "perception/training/verifier_training.h"
#include "scenes/base/ids.h"

namespace pickbed::perception {

// Views to be rendered.
struct TrainingViewsPlan {
  uint64_t seed = 0;
  std::vector<PatchForm> forms;         // patch form by object
  std::vector<ObjectId> scene_objects;  // required object of each clutter scene
  std::vector<ObjectId> verifiers;      // objects whose verifiers are trained, in this order
  int views_per_scene = 3;
  PositivePairOptions positive_pairs;
  HeldOutOptions held_out;
  VerifierTrainingOptions verifier;
  std::vector<VerifierDeadlines> deadlines = {};  // by verifier; empty = no time limit
};

// Training pairs of one clutter scene, by object.
using ClutterPairs = std::vector<PatchPairs>;

// Thread that renders the plan.
class TrainingViews {
 public:
  // Starts the thread. Only the thread may use `source` until this object is destroyed.
  TrainingViews(LabelledViewSource& source, TrainingViewsPlan plan);
  // Stops the thread; waits for the view in progress.
  ~TrainingViews();

  // Return the next item of each kind, or nothing if it is not ready within `wait`. Rethrow an
  // exception of the thread.
  using Wait = std::chrono::milliseconds;
  std::optional<HeldOutSet> TakeHeldOut(Wait wait);
  std::optional<ClutterPairs> TakeScene(Wait wait);
  std::optional<VerifierTrainingSet> TakeTrainingSet(Wait wait);

  // Skips the remaining clutter scenes.
  void SkipScenes();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed::perception
