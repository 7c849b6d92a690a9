#pragma once

// Ranges for the appearance of scenes: lamp, materials and background. Each value is drawn
// uniformly from its range (domain randomization as in Tobin et al., IROS 2017).
// sim/render/appearance.h draws them.

#include <functional>
#include <string>

#include "scenes/base/settings.h"

namespace pickbed::scenes {

// Interval from min to max; equal ends fix the value.
struct Span {
  double min = 0;
  double max = 0;
  friend bool operator==(const Span&, const Span&) = default;
};

// The ranges; their limits are in appearance_ranges.cpp.
struct AppearanceRanges {
  Span lamp_x_m{-0.8, 0.8};  // position of the lamp in W
  Span lamp_y_m{-0.8, 0.8};
  Span lamp_z_m{0.8, 1.8};
  Span ambient{0.25, 0.45};  // 0..1; the rest of the light comes from the lamp
  double shadow_share = 0;   // 0..1, share of scenes that have a shadow
  Span shadow_softness_m{0.001, 0.01};
  Span tint{1, 1};                // 0..1, factor of red, green and blue, drawn separately
  Span gloss{0, 0};               // 0..1, strength of the white highlight
  Span grain{0, 0};               // 0..1, depth of a dark pattern
  Span grain_cells_pm{100, 800};  // cells per metre
  Span background{0, 0};          // 0..1, grey of pixels without a surface, drawn per cell
  Span background_cell_px{8, 64};

  void Visit(SettingsVisitor& v);

  // Throws InputError, naming the range, if its ends are swapped or outside the limits. `at`
  // converts a key such as "gloss" into its name in the message.
  void Validate(const std::function<std::string(const std::string& key)>& at = {}) const;
};

// Returns ranges without variation: the default lamp, plain materials and black background.
AppearanceRanges FixedAppearance();

// Returns ranges in which everything varies, as much as in a real cell.
AppearanceRanges WideAppearance();

}  // namespace pickbed::scenes
