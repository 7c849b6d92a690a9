#include "scenes/scenario/occlusion_spec.h"

#include <fmt/format.h>

#include "scenes/base/error.h"

namespace pickbed::scenes {

bool VisibleBand::Holds(double fraction) const {
  return fraction >= least && (fraction < most || (most >= 1 && fraction <= most));
}

std::string VisibleBand::name() const {
  return fmt::format("{:.4g}-{:.4g}", 100 * least, 100 * most);
}

void VisibleBand::Visit(SettingsVisitor& v) {
  v.Real("least", least, {0, 1}, "visible fraction from here on");
  v.Real("most", most, {0, 1}, "and below this; 1 is included");
}

void OcclusionSpec::Visit(SettingsVisitor& v) {
  v.Bool("enabled", enabled, "each trial is one target, seen and picked once in each band");
  v.List(
      "bands", bands.size(), [this](size_t n) { bands.assign(n, VisibleBand{}); },
      [this](size_t i, SettingsVisitor& item) { bands[i].Visit(item); },
      "of the target's visible fraction, from the least visible on");
  v.Real("margin", margin, {0, 0.1}, "fractions nearer to a band's end are not taken");
  v.Integer("level_tries", level_tries, {0, 100000},
            "blockers dropped to come nearer to a fraction drawn evenly over the band");
  v.Integer("max_blockers", max_blockers, {1, 1000}, "parts that may hide a target");
  v.Integer("tries", tries, {1, 100000}, "blockers dropped for one band of a target, at most");
  v.Integer("targets", targets, {1, 1000}, "tried in one scene, at most");
  v.Integer("scenes", scenes, {1, 1000}, "dropped for one trial, at most");
  v.Real("scatter_diameters", scatter_diameters, {0, 5},
         "of a blocker from the line of sight, in its diameters");
  v.Real("least_hidden", least_hidden, {0, 1}, "share of the target that a blocker hides at least");
  v.Real("movement_diameters", movement_diameters, {0.0001, 1},
         "no surface moves further in a second awake");
}

void OcclusionSpec::Validate(const std::function<std::string(const std::string& key)>& at) const {
  const auto name = [&](const std::string& key) { return at ? at(key) : key; };
  CheckInput(!bands.empty(), name("bands") + ": is empty; add '- {least: 0.5, most: 0.7}'");
  for (size_t i = 0; i < bands.size(); ++i) {
    const VisibleBand& band = bands[i];
    CheckInput(
        band.most - band.least > 2 * margin,
        fmt::format("{} = {}: must be over bands.{}.least = {} by more than twice the "
                    "margin of {}",
                    name(fmt::format("bands.{}.most", i)), band.most, i, band.least, margin));
    CheckInput(
        i == 0 || band.least >= bands[i - 1].most,
        fmt::format("{} = {}: must not be under bands.{}.most = {}; list the bands from the "
                    "least visible on, without overlap",
                    name(fmt::format("bands.{}.least", i)), band.least, i - 1, bands[i - 1].most));
  }
}

VisibleBand OcclusionSpec::Inner(int band) const {
  VisibleBand inner = bands[band];
  if (inner.least > 0) inner.least += margin;
  if (inner.most < 1) inner.most -= margin;
  return inner;
}

int OcclusionSpec::BandOf(double fraction) const {
  for (int band = 0; band < static_cast<int>(bands.size()); ++band) {
    if (Inner(band).Holds(fraction)) return band;
  }
  return -1;
}

}  // namespace pickbed::scenes
