#include "eval/summary/clutter_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "eval/cell/simulated_cell.h"
#include "eval/stats/statistics.h"
#include "eval/summary/run_summary.h"

namespace pickbed::eval {

ClutterSummary ClutterOfBin(const ClutterStatistics& clutter) {
  ClutterSummary summary{1,  clutter.instances, clutter.fill_level, clutter.layers,
                         {}, clutter.counted,   clutter.tested,     clutter.graspable};
  summary.in_view.resize(InViewNames().size());
  for (const double fraction : clutter.visible_fraction) ++summary.in_view[InViewIndex(fraction)];
  return summary;
}

ClutterSummary ClutterOfTrials(std::span<const TrialResult> trials) {
  ClutterSummary summary;
  summary.in_view.resize(InViewNames().size());
  for (const TrialResult& trial : trials) {
    if (trial.layers.empty() || trial.attempts.empty()) continue;
    const AttemptRecord& first = trial.attempts.front();
    ++summary.bins;
    summary.instances += static_cast<int>(first.instances.size());
    summary.fill_level += first.fill_level;
    if (trial.layers.size() > summary.layers.size()) summary.layers.resize(trial.layers.size());
    for (size_t i = 0; i < trial.layers.size(); ++i) summary.layers[i] += trial.layers[i];
    int counted = 0;
    for (const InstanceRecord& instance : first.instances) {
      const size_t band = InViewIndex(instance.visible_fraction);
      if (band == 0) continue;  // hidden, or a distractor
      ++summary.in_view[band];
      ++counted;
    }
    summary.in_view[0] += trial.instances_dropped - counted;
    summary.counted += counted;
    summary.tested += trial.instances_tested;
    summary.graspable += trial.instances_graspable;
  }
  if (summary.bins > 0) summary.fill_level /= summary.bins;
  return summary;
}

ResultColumns ClutterKeys() {
  return {
      {"bins", "number of bins"},
      {"instances", "number of instances in the bins"},
      {"fill_level", "mean height of the pile's surface over the inner height of the bin", "0..1"},
      {"layers", "number of instances in each layer, from the top"},
      {"in_view.BAND", "number of wanted instances by visible fraction in percent"},
      {"counted", "number of wanted instances that are at least 10 % visible"},
      {"tested",
       "number of them for which a grasp was planned, at the true poses; 0 for planners without "
       "poses"},
      {"graspable", "number of tested ones with a grasp that meets nothing"},
      {"gripper", "name of the gripper for it"},
  };
}

std::string ClutterJson(const ClutterSummary& clutter, const std::string& gripper) {
  nlohmann::ordered_json json;
  json["bins"] = clutter.bins;
  json["instances"] = clutter.instances;
  json["fill_level"] = clutter.fill_level;
  json["layers"] = clutter.layers;
  const std::vector<std::string> names = InViewNames();
  for (size_t i = 0; i < names.size(); ++i) json["in_view"][names[i]] = clutter.in_view[i];
  json["counted"] = clutter.counted;
  json["tested"] = clutter.tested;
  json["graspable"] = clutter.graspable;
  if (!gripper.empty()) json["gripper"] = gripper;
  return json.dump(2) + "\n";
}

std::string ClutterText(const ClutterSummary& clutter, const std::string& gripper) {
  const std::vector<std::string> names = InViewNames();
  std::string visible;
  for (size_t i = names.size(); i-- > 0;) {
    visible += fmt::format("{}{} % {}", visible.empty() ? "" : ", ", names[i], clutter.in_view[i]);
  }
  const bool several = clutter.bins > 1;
  const std::string text = fmt::format(
      "{}fill level {:.0f} % of the bin's height; {} instance{}{} in layers from the top: {}\n"
      "by visible fraction: {}\n",
      several ? "mean " : "", 100 * clutter.fill_level, clutter.instances,
      clutter.instances == 1 ? "" : "s", several ? fmt::format(" of {} bins", clutter.bins) : "",
      fmt::join(clutter.layers, ", "), visible);
  const std::string min_visibility = WholePercentText(kCountedVisibility);
  if (clutter.tested == 0) {
    return text +
           fmt::format("{} instances are at least {} visible\n", clutter.counted, min_visibility);
  }
  return text + fmt::format("{} of {}{} instances that are at least {} visible can be grasped{}\n",
                            clutter.graspable, clutter.tested,
                            clutter.tested < clutter.counted ? " tested" : "", min_visibility,
                            gripper.empty() ? "" : " with " + gripper);
}

}  // namespace pickbed::eval
