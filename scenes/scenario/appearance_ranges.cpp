#include "scenes/scenario/appearance_ranges.h"

#include <fmt/format.h>

#include "scenes/base/error.h"

namespace pickbed::scenes {
namespace {

constexpr Range kLamp_m{-100, 100};
constexpr Range kShare{0, 1};
constexpr Range kSoftness_m{0, 0.1};
constexpr Range kGrainCells_pm{1, 1e5};
constexpr Range kBackgroundCell_px{1, 1e4};

// Calls `take` for each range with its key, limits and help. Settings and checks both use it.
template <typename Ranges, typename Take>
void ForEachSpan(Ranges& r, Take take) {
  take("lamp_x_m", r.lamp_x_m, kLamp_m, "x position of the lamp in the world frame, m");
  take("lamp_y_m", r.lamp_y_m, kLamp_m, "y position of the lamp in the world frame, m");
  take("lamp_z_m", r.lamp_z_m, kLamp_m, "z position of the lamp in the world frame, m");
  take("ambient", r.ambient, kShare, "share of the light that is ambient");
  take("shadow_softness_m", r.shadow_softness_m, kSoftness_m,
       "half width of the edge of a shadow, m");
  take("tint", r.tint, kShare,
       "factor of an instance's red, green and blue, each drawn separately");
  take("gloss", r.gloss, kShare, "strength of an instance's white highlight");
  take("grain", r.grain, kShare, "depth of a dark pattern on an instance");
  take("grain_cells_pm", r.grain_cells_pm, kGrainCells_pm, "cells of the dark pattern per metre");
  take("background", r.background, kShare, "grey value of the background squares, 0 = black");
  take("background_cell_px", r.background_cell_px, kBackgroundCell_px,
       "size of the background squares, px");
}

}  // namespace

void AppearanceRanges::Visit(SettingsVisitor& v) {
  ForEachSpan(*this, [&v](const char* key, Span& span, Range range, const char* help) {
    Eigen::Vector2d ends(span.min, span.max);
    v.Vector2(key, ends, range, help);
    span = {ends[0], ends[1]};
  });
  v.Real("shadow_share", shadow_share, kShare, "share of scenes with a shadow");
}

void AppearanceRanges::Validate(
    const std::function<std::string(const std::string& key)>& at) const {
  const auto check = [&](const std::string& key, const Span& span, Range range) {
    CheckInput(span.min >= range.min && span.max >= span.min && span.max <= range.max,
               fmt::format("{} = [{}, {}]: must be the minimum and the maximum of a range within "
                           "{} to {}, the minimum first",
                           at ? at(key) : key, span.min, span.max, range.min, range.max));
  };
  ForEachSpan(*this, [&](const char* key, const Span& span, Range range, const char*) {
    check(key, span, range);
  });
  check("shadow_share", {shadow_share, shadow_share}, kShare);
}

AppearanceRanges FixedAppearance() {
  AppearanceRanges ranges;
  ranges.lamp_x_m = {0.3, 0.3};
  ranges.lamp_y_m = {-0.4, -0.4};
  ranges.lamp_z_m = {1.5, 1.5};
  ranges.ambient = {0.35, 0.35};
  ranges.shadow_softness_m = {0.002, 0.002};
  return ranges;
}

AppearanceRanges WideAppearance() {
  AppearanceRanges ranges;
  ranges.ambient = {0.15, 0.6};
  ranges.shadow_share = 0.7;
  ranges.tint = {0.4, 1};
  ranges.gloss = {0, 0.6};
  ranges.grain = {0, 0.5};
  ranges.background = {0, 1};
  return ranges;
}

}  // namespace pickbed::scenes
