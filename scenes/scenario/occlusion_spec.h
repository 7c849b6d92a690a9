#pragma once

// Settings of the controlled occlusion experiment. One target is captured with a decreasing visible
// fraction, once in each band. sim/drop/occlusion_series.h builds the scenes.

#include <functional>
#include <string>
#include <vector>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// Interval of visible fractions: `min` is included, `max` is excluded unless it is 1.
struct VisibleBand {
  double min = 0;
  double max = 1;
  bool Holds(double fraction) const;
  std::string name() const;  // in percent, such as "10-30"
  void Visit(SettingsVisitor& v);
  friend bool operator==(const VisibleBand&, const VisibleBand&) = default;
};

// Settings of the experiment.
struct OcclusionSpec {
  bool enabled = false;  // false = normal trials, in which a bin is emptied
  std::vector<VisibleBand> bands{{0.1, 0.3}, {0.3, 0.5}, {0.5, 0.7}, {0.7, 0.9}, {0.9, 1}};
  // Fractions closer than this to an end of a band are rejected, so that another renderer agrees on
  // the band.
  double margin = 0.005;
  // Blockers dropped after the target is in a band, to come closer to a fraction that is drawn
  // uniformly over the band. 0 = keep the first scene of the band, usually near its upper end.
  int level_samples = 6;
  int max_blockers = 16;     // largest number of blockers in a scene
  int blocker_samples = 60;  // largest number of blockers dropped for one band of one target
  int targets = 3;           // largest number of targets in one scene until one fills all bands
  int scenes = 3;            // largest number of scenes dropped for one trial
  // Largest distance from the line of sight at which a blocker is dropped, in its diameters.
  double scatter_diameters = 0.5;
  double min_hidden = 0.02;  // share of the target; a blocker that hides less is removed again
  // Largest movement of a surface while all bodies are awake for a second, in diameters; see
  // SceneCertificate.
  double movement_diameters = 0.02;

  void Visit(SettingsVisitor& v);

  // Throws InputError for values out of range, and unless there is a band, each band is wider than
  // twice the margin, and the bands are ordered from the least visible one without overlap. `at`
  // converts a key such as "bands.0.min" into its name in the message.
  void Validate(const std::function<std::string(const std::string& key)>& at = {}) const;

  // Returns a band without the margins at its ends; the ends 0 and 1 have no margin.
  VisibleBand Inner(int band) const;
  // Returns the band that contains `fraction` with the margin, or -1 if there is none.
  int BandOf(double fraction) const;
};

}  // namespace pickbed::scenes
