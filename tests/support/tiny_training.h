#pragma once

// Options of a short training, for tests.

#include "perception/training/training.h"
#include "tests/support/layer.h"

namespace pickbed::tests {

// Seconds of training: enough to learn something, not enough to be good.
inline TrainingOptions TinyOptions() {
  TrainingOptions options;
  options.clutter_scenes = 4;
  options.views_per_scene = 1;
  options.positive_pairs.patches_per_view = 60;
  options.verifier_entries = 480;
  options.iterations = 24;
  options.batch = 24;
  options.verifier_clutter_scenes = 2;
  options.verifier_room_scenes = 2;
  options.checkpoint_every = 8;
  options.network.descriptor = 8;
  options.verifier.iterations = 50;
  options.candidates.points = 40;
  options.candidates.candidates = 30;
  options.candidates.min_candidates = 10;
  options.fast_candidates = options.candidates;
  options.held_out.clutter_scenes = 2;
  options.held_out.queries = 40;
  options.held_out.book_views = 20;
  options.held_out.every = 8;
  return options;
}

}  // namespace pickbed::tests
