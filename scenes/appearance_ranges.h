#pragma once

// How scenes may look: lamps, materials and what stands behind the parts, each drawn evenly from a
// named range (domain randomisation as in Tobin et al., IROS 2017). sim/appearance.h draws them.

#include <functional>
#include <string>

#include "scenes/settings.h"

namespace pickbed {

// From min to max; equal ones fix the value.
struct Span {
  double min = 0;
  double max = 0;
  friend bool operator==(const Span&, const Span&) = default;
};

struct AppearanceRanges {
  Span lamp_x_m{-0.8, 0.8};  // in the world's frame
  Span lamp_y_m{-0.8, 0.8};
  Span lamp_z_m{0.8, 1.8};
  Span ambient{0.25, 0.45};  // 0..1; the rest of the light comes from the lamp
  double shadow_share = 0;   // 0..1, of pictures that have a shadow
  Span shadow_softness_m{0.001, 0.01};
  Span tint{1, 1};                // 0..1, factor of red, green and blue, each drawn by itself
  Span gloss{0, 0};               // 0..1
  Span grain{0, 0};               // 0..1, depth of a dark pattern
  Span grain_cells_pm{100, 800};  // cells a metre
  Span background{0, 0};          // 0..1, grey of pixels that show nothing, drawn per cell
  Span background_cell_px{8, 64};

  void Visit(SettingsVisitor& v);

  // Throws InputError naming the range that is turned round or outside its limits. `at` turns a key
  // such as "gloss" into how the message names it.
  void Validate(const std::function<std::string(const std::string& key)>& at = {}) const;
};

// Nothing varies: the lamp, the plain materials and the black background that pictures have unless
// a scenario says otherwise.
AppearanceRanges FixedAppearance();

// Everything varies, as much as a real cell may.
AppearanceRanges WideAppearance();

}  // namespace pickbed
