#include "perception/training/training.h"

namespace pickbed::perception {

void TrainingOptions::Visit(SettingsVisitor& v) {
  v.Seed("seed", seed, "of weights, views and batches");
  v.RenamedKey("piles", "clutter_scenes");
  v.Integer("clutter_scenes", clutter_scenes, {1, 100000}, "training piles per part");
  v.RenamedKey("views_per_pile", "views_per_scene");
  v.Integer("views_per_scene", views_per_scene, {1, 100}, "views of each");
  v.RenamedKey("twins", "positive_pairs");
  v.Group(
      "positive_pairs", [&](SettingsVisitor& g) { positive_pairs.Visit(g); },
      "the pairs to learn from");
  v.Integer("iterations", iterations, {0, 10000000}, "steps per part; 0 = verifiers alone");
  v.Integer("batch", batch, {2, 100000}, "pairs of patches in a step");
  v.Real("main_share", main_share, {0, 1}, "share of a batch that is of one part");
  v.Real("patch_diameters", patch_diameters, {0.05, 4}, "side of a patch over the diameter");
  v.Real("learning_rate", learning_rate, {1e-7, 1}, "of Adam, at the start of the cosine");
  v.Real("views_share", views_share, {0.01, 1}, "of the steps, by which all piles are in");
  v.Real("rehearsal", rehearsal, {0.001, 1},
         "piles and steps of a part that the model begun with knows, over another's");
  v.RenamedKey("verifier_piles", "verifier_clutter_scenes");
  v.Integer("verifier_clutter_scenes", verifier_clutter_scenes, {1, 100000},
            "piles per part for the verifier");
  v.Integer("verifier_entries", verifier_entries, {1, 10000000},
            "code book entries per part while the verifier learns");
  v.Integer("checkpoint_every", checkpoint_every, {1, 1000000}, "steps");
  v.Real("max_minutes", max_minutes, {0, 1e6}, "of views and network; 0 = no limit");
  v.Group(
      "network", [&](SettingsVisitor& g) { network.Visit(g); }, "the network");
  v.Group(
      "loss", [&](SettingsVisitor& g) { loss.Visit(g); }, "what it is taught");
  v.Group(
      "verifier", [&](SettingsVisitor& g) { verifier.Visit(g); }, "the verifier's training");
  v.Group(
      "held_out", [&](SettingsVisitor& g) { held_out.Visit(g); }, "recall on patches not learned");
  v.Group(
      "candidates", [&](SettingsVisitor& g) { candidates.Visit(g); },
      "how the candidates are found that the verifier learns on");
  v.Group(
      "fast_candidates", [&](SettingsVisitor& g) { fast_candidates.Visit(g); },
      "the same in mode fast; its votes are those of candidates");
}

}  // namespace pickbed::perception
