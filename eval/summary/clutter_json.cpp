#include "eval/summary/clutter_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "eval/stats/statistics.h"
#include "eval/summary/run_summary.h"

namespace pickbed::eval {
namespace {

// Returns the number of instances in each of InViewNames().
std::vector<int> InViewCounts(const ClutterStatistics& clutter) {
  std::vector<int> counts(InViewNames().size());
  for (const double fraction : clutter.visible_fraction) ++counts[InViewIndex(fraction)];
  return counts;
}

}  // namespace

ResultColumns ClutterKeys() {
  return {
      {"instances", "number of instances in the bin"},
      {"fill_level", "mean height of the pile's surface over the inner height of the bin", "0..1"},
      {"layers", "number of instances in each layer, from the top"},
      {"in_view.BAND", "number of wanted instances by visible fraction in percent"},
      {"counted", "number of wanted instances that are at least 10 % visible"},
      {"graspable", "number of them with a grasp that meets nothing, at the true poses"},
      {"gripper", "name of the gripper for it"},
  };
}

std::string ClutterJson(const ClutterStatistics& clutter, const std::string& gripper) {
  nlohmann::ordered_json json;
  json["instances"] = clutter.instances;
  json["fill_level"] = clutter.fill_level;
  json["layers"] = clutter.layers;
  const std::vector<std::string> names = InViewNames();
  const std::vector<int> counts = InViewCounts(clutter);
  for (size_t i = 0; i < names.size(); ++i) json["in_view"][names[i]] = counts[i];
  json["counted"] = clutter.counted;
  json["graspable"] = clutter.graspable;
  json["gripper"] = gripper;
  return json.dump(2) + "\n";
}

std::string ClutterText(const ClutterStatistics& clutter, const std::string& gripper) {
  const std::vector<std::string> names = InViewNames();
  const std::vector<int> counts = InViewCounts(clutter);
  std::string visible;
  for (size_t i = names.size(); i-- > 0;) {
    visible += fmt::format("{}{} % {}", visible.empty() ? "" : ", ", names[i], counts[i]);
  }
  return fmt::format(
      "fill level {:.0f} % of the bin's height; {} instances in layers from the top: {}\n"
      "by visible fraction: {}\n"
      "{} of {} instances that are at least {} visible can be grasped with {}\n",
      100 * clutter.fill_level, clutter.instances, fmt::join(clutter.layers, ", "), visible,
      clutter.graspable, clutter.counted, WholePercentText(kCountedVisibility), gripper);
}

}  // namespace pickbed::eval
