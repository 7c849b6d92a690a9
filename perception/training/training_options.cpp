#include <fmt/format.h>

#include "perception/training/shared_verifier.h"
#include "perception/training/training.h"
#include "perception/training/verifier_training.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {

void TrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "random seed of weights, views and batches");
  v.RenamedKey("piles", "clutter_scenes");
  v.Integer("clutter_scenes", clutter_scenes, {1, 100000}, "number of clutter scenes per object");
  v.RenamedKey("views_per_pile", "views_per_scene");
  v.Integer("views_per_scene", views_per_scene, {1, 100}, "number of views of each clutter scene");
  v.RenamedKey("twins", "positive_pairs");
  v.Group(
      "positive_pairs", [&](SettingsVisitor& g) { positive_pairs.Visit(g); },
      "training pairs of patches");
  v.Integer("iterations", iterations, {0, 10000000},
            "training steps per object; 0 = only verifiers are trained");
  v.Integer("batch", batch, {2, 100000}, "pairs of patches per step");
  v.Real("main_share", main_share, {0, 1}, "share of a batch from one object");
  v.Real("patch_diameters", patch_diameters, {0.05, 4}, "side of a patch, object diameters");
  v.Real("learning_rate", learning_rate, {1e-7, 1},
         "learning rate of Adam at the start of the cosine schedule");
  v.Real("views_share", views_share, {0.01, 1},
         "share of the steps after which all clutter scenes are in use");
  v.Bool("verifiers_only", verifiers_only,
         "keep the network of the initial model and train only the verifiers of all objects");
  v.Real("rehearsal", rehearsal, {0.001, 1},
         "scenes and steps of an object that the initial model knows, relative to a new object");
  v.RenamedKey("verifier_piles", "verifier_clutter_scenes");
  v.Integer("verifier_clutter_scenes", verifier_clutter_scenes, {0, 100000},
            "number of clutter scenes per object for its verifier; 0 = with verifiers_only, keep "
            "what the initial model knows for known backgrounds");
  v.Integer("verifier_room_scenes", verifier_room_scenes, {0, 100000},
            "number of rooms per object for its verifier, of which every second has no object; 0 = "
            "no verifier for unknown backgrounds");
  v.Text(
      "shared_verifier", shared_verifier, {},
      "network for unknown backgrounds, made by `pickbed train verifier` from many objects, that "
      "gives half of the logit of each object: a file, or none");
  v.Integer("verifier_entries", verifier_entries, {1, 10000000},
            "number of codebook entries per object while its verifier is trained");
  v.Integer("checkpoint_every", checkpoint_every, {1, 1000000},
            "number of steps between two checkpoints");
  v.Real("max_minutes", max_minutes, {0, 1e6},
         "time limit of views, network and verifiers together, minutes; 0 = no limit");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "settings of the network");
  v.Group(
      "loss", [&](SettingsVisitor& g) { loss.Visit(g); }, "loss of the training");
  v.Group(
      "verifier", [&](SettingsVisitor& g) { verifier.Visit(g); }, "training of the verifiers");
  v.Group(
      "held_out", [&](SettingsVisitor& g) { held_out.Visit(g); },
      "recall on held-out patches during training");
  v.Group(
      "candidates", [&](SettingsVisitor& g) { candidates.Visit(g); },
      "search for the candidates with which the verifier is trained");
  v.Group(
      "fast_candidates", [&](SettingsVisitor& g) { fast_candidates.Visit(g); },
      "the same search in mode fast; it uses the votes of candidates");
}

VerifierTrainingOptions VerifierOptionsOf(const TrainingOptions& options) {
  VerifierTrainingOptions verifier;
  verifier.seed = options.seed;
  verifier.clutter_scenes = options.verifier_clutter_scenes;
  verifier.room_scenes = options.verifier_room_scenes;
  verifier.views_per_scene = options.views_per_scene;
  verifier.entries = options.candidates.votes == "regressed" ? 0 : options.verifier_entries;
  verifier.candidates = {options.candidates, options.fast_candidates};
  verifier.candidates.back().votes = options.candidates.votes;
  verifier.verifier = options.verifier;
  if (options.shared_verifier != kNoSharedVerifier) {
    verifier.shared_network = LoadSharedVerifier(TrainedFile(options.shared_verifier));
  }
  return verifier;
}

}  // namespace pickbed::perception
