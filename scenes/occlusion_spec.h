#pragma once

// The designed experiment on occlusion, as settings: one target is seen with ever less of it in
// view, once in each band of its visible fraction. sim/occluded_scene.h builds the scenes.

#include <functional>
#include <string>
#include <vector>

#include "scenes/settings.h"

namespace pickbed {

// Visible fractions from `least` on and below `most`; a band that ends at 1 holds 1.
struct VisibleBand {
  double least = 0;
  double most = 1;
  bool Holds(double fraction) const;
  std::string name() const;  // "10-30"
  void Visit(SettingsVisitor& v);
  friend bool operator==(const VisibleBand&, const VisibleBand&) = default;
};

struct OcclusionSpec {
  bool enabled = false;  // else trials are as ever: a bin is picked empty
  std::vector<VisibleBand> bands{{0.1, 0.3}, {0.3, 0.5}, {0.5, 0.7}, {0.7, 0.9}, {0.9, 1}};
  // Fractions nearer than this to an end of a band are not taken, so that another renderer agrees.
  double margin = 0.005;
  // Blockers dropped, once a band holds the target, to come nearer to a fraction that is drawn
  // evenly over the band; 0 = the first scene of the band is kept, as a rule from its upper end.
  int level_tries = 6;
  int max_blockers = 16;  // that lie in a scene at last
  int tries = 60;         // blockers dropped for one band of one target, at most
  int targets = 3;        // tried in one scene until one has been seen in all bands
  int scenes = 3;         // dropped for one trial
  // Where a blocker is dropped: this far, at most, from the line of sight, in its diameters.
  double scatter_diameters = 0.5;
  double least_hidden = 0.02;  // of the target; a blocker that hides less is taken back
  // No surface may move further while all parts are awake for a second: see SceneCertificate.
  double movement_diameters = 0.02;

  void Visit(SettingsVisitor& v);

  // At least one band, each with its ends in order, from the least visible on and without overlap.
  // Throws InputError. `at` turns a key such as "bands.0.least" into how the message names it.
  void Validate(const std::function<std::string(const std::string& key)>& at = {}) const;

  // A band without the margins at its ends; 0 and 1 have none.
  VisibleBand Inner(int band) const;
  // The band that holds `fraction` by the margin at least; -1 = none.
  int BandOf(double fraction) const;
};

}  // namespace pickbed
