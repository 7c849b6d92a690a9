#include "scenes/scenario/occlusion_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/base/error.h"

namespace pickbed::scenes {

bool VisibleBand::Holds(double fraction) const {
  return fraction >= min && (fraction < max || (max >= 1 && fraction <= max));
}

std::string VisibleBand::name() const { return fmt::format("{:.4g}-{:.4g}", 100 * min, 100 * max); }

void VisibleBand::Visit(SettingsVisitor& v) {
  v.RenamedKey("least", "min");
  v.Real("min", min, {0, 1}, "lower limit of the visible fraction, inclusive");
  v.RenamedKey("most", "max");
  v.Real("max", max, {0, 1}, "upper limit of the visible fraction, exclusive except for 1");
}

void OcclusionSpec::Visit(SettingsVisitor& v) {
  v.Bool("enabled", enabled,
         "whether a trial shows one target once in each band, instead of emptying the bin");
  v.List(
      "bands", bands.size(), [this](size_t n) { bands.assign(n, VisibleBand{}); },
      [this](size_t i, SettingsVisitor& item) { bands[i].Visit(item); },
      "bands of the target's visible fraction, least visible first");
  v.Real("margin", margin, {0, 0.1},
         "visible fractions closer than this to an end of a band are rejected");
  v.RenamedKey("level_tries", "level_samples");
  v.Integer("level_samples", level_samples, {0, 100000},
            "blockers dropped to come closer to the fraction drawn for a band; 0 = none");
  v.Integer("max_blockers", max_blockers, {1, 1000}, "maximum number of blockers in a scene");
  v.RenamedKey("tries", "blocker_samples");
  v.Integer("blocker_samples", blocker_samples, {1, 100000},
            "maximum number of blockers dropped for one band of a target");
  v.Integer("targets", targets, {1, 1000}, "maximum number of targets tried in one scene");
  v.Integer("scenes", scenes, {1, 1000}, "maximum number of scenes dropped for one trial");
  v.Real("scatter_diameters", scatter_diameters, {0, 5},
         "maximum distance of a dropped blocker from the line of sight, in its diameters");
  v.RenamedKey("least_hidden", "min_hidden");
  v.Real("min_hidden", min_hidden, {0, 1}, "minimum share of the target that a blocker must hide");
  v.Real("movement_diameters", movement_diameters, {0.0001, 1},
         "maximum movement of a surface in one second while all bodies are awake, diameters");
}

void OcclusionSpec::Validate(const std::function<std::string(const std::string& key)>& at) const {
  const auto name = [&](const std::string& key) { return at ? at(key) : key; };
  OcclusionSpec copy = *this;
  const std::vector<std::string> faults =
      SettingFaults([&copy](SettingsVisitor& v) { copy.Visit(v); }, at);
  CheckInput(faults.empty(), fmt::format("{}", fmt::join(faults, "; ")));
  CheckInput(!bands.empty(), name("bands") + ": is empty; add '- {min: 0.5, max: 0.7}'");
  for (size_t i = 0; i < bands.size(); ++i) {
    const VisibleBand& band = bands[i];
    CheckInput(
        band.max - band.min > 2 * margin,
        fmt::format("{} = {}: must exceed bands.{}.min = {} by more than twice the margin of {}",
                    name(fmt::format("bands.{}.max", i)), band.max, i, band.min, margin));
    if (i == 0) continue;
    CheckInput(
        band.min >= bands[i - 1].max,
        fmt::format("{} = {}: must not be under bands.{}.max = {}; list the bands from the "
                    "least visible on, without overlap",
                    name(fmt::format("bands.{}.min", i)), band.min, i - 1, bands[i - 1].max));
  }
}

VisibleBand OcclusionSpec::Inner(int band) const {
  VisibleBand inner = bands[band];
  if (inner.min > 0) inner.min += margin;
  if (inner.max < 1) inner.max -= margin;
  return inner;
}

int OcclusionSpec::BandOf(double fraction) const {
  for (int band = 0; band < static_cast<int>(bands.size()); ++band) {
    if (Inner(band).Holds(fraction)) return band;
  }
  return -1;
}

}  // namespace pickbed::scenes
