#pragma once

// All views that a training asks for, made in a thread of its own while the network learns: the
// held-out set, then the piles one by one, then what each part's verifier learns from. The order is
// fixed and each item depends on its number alone, so what comes out does not depend on time.

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "perception/held_out.h"
#include "perception/verifier_training.h"

namespace pickbed {

struct TrainingViewsPlan {
  uint64_t seed = 0;
  std::vector<PatchForm> forms;  // of the patches, by part
  std::vector<int> pile_parts;   // the part that each pile holds for certain
  std::vector<int> verifiers;    // parts whose verifiers are trained, in this order
  int views_per_pile = 3;
  TwinOptions twins;
  HeldOutOptions held_out;
  VerifierTrainingOptions verifier;
};

// The pairs of one pile, by part.
using PilePairs = std::vector<PatchPairs>;

class TrainingViews {
 public:
  // From now on and until it is destroyed, `source` belongs to the thread.
  TrainingViews(LabelledViewSource& source, TrainingViewsPlan plan);
  // Waits for the view under way.
  ~TrainingViews();

  // The next of each kind, waiting for at most `wait`; nullopt: not made yet. What the thread threw
  // is thrown here.
  using Wait = std::chrono::milliseconds;
  std::optional<HeldOutSet> TakeHeldOut(Wait wait);
  std::optional<PilePairs> TakePile(Wait wait);
  std::optional<VerifierLesson> TakeLesson(Wait wait);

  // No more piles are wanted.
  void SkipPiles();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pickbed
