#include "eval/compare/paired_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "eval/metrics/interval_json.h"

namespace pickbed::eval {
namespace {

// Formats rates in percent, errors in their unit.
std::string ValueText(const PairedStatistic& statistic, double value) {
  return statistic.is_rate ? PercentText(value) : fmt::format("{:.3g}", value);
}

TableCells CellsOf(const PairedComparison& comparison, const std::string& before,
                   const std::string& after) {
  TableCells cells{{"statistic", before, after, "difference [95 %]", "p", "bins", "different bins",
                    "bins needed"}};
  for (const PairedStatistic& statistic : comparison.statistics) {
    cells.push_back({statistic.name, ValueText(statistic, statistic.before),
                     ValueText(statistic, statistic.after), DifferenceText(statistic),
                     fmt::format("{:.3g}", statistic.p_value), std::to_string(statistic.scenes),
                     std::to_string(statistic.discordant_scenes),
                     statistic.scenes_needed ? std::to_string(*statistic.scenes_needed) : ""});
  }
  return cells;
}

}  // namespace

ConfigurationComparison CompareConfigurations(const PairedConfiguration& before,
                                              const PairedConfiguration& after) {
  return {before.trials->name, after.trials->name,
          ComparePaired(before.trials->trials, after.trials->trials, before.trials->bands)};
}

ReportTable PairedReport(const ConfigurationComparison& compared) {
  const std::string &first = compared.before, &second = compared.after;
  const PairedComparison& comparison = compared.paired;
  std::string text = fmt::format(
      "{} minus {}, on the {} bins that both have. Rates are in percentage points. Errors are "
      "for the instances that both found, of the pose with the highest score on each. p: McNemar's "
      "exact test if a bin has one outcome, otherwise a sign-flip test over bins. Bins needed: to "
      "detect a difference of this size with a power of 0.8 at the level 0.05; only for rates, not "
      "for medians.",
      second, first, comparison.scenes);
  if (comparison.before_only + comparison.after_only > 0) {
    text += fmt::format(" Not included: {} bins that only the first run has and {} of the second.",
                        comparison.before_only, comparison.after_only);
  }
  return {fmt::format("Paired differences: {} against {}", second, first), text,
          CellsOf(comparison, first, second)};
}

std::vector<ConfigurationComparison> CompareWithFirst(
    const std::vector<PairedConfiguration>& configurations) {
  std::vector<ConfigurationComparison> comparisons;
  for (const PairedConfiguration& configuration : configurations) {
    const auto first = std::ranges::find(
        configurations, SceneKey(configuration.identity),
        [](const PairedConfiguration& other) { return SceneKey(other.identity); });
    if (&*first != &configuration) {
      comparisons.push_back(CompareConfigurations(*first, configuration));
    }
  }
  return comparisons;
}

std::string ComparisonText(std::span<const ConfigurationComparison> comparisons, bool all_rows,
                           const std::string& remedy) {
  std::string text;
  for (const ConfigurationComparison& comparison : comparisons) {
    text += fmt::format("A is {}, B is {}; {}\n", comparison.before, comparison.after,
                        PairedTable(comparison.paired, all_rows, remedy));
  }
  return text;
}

ResultColumns ComparisonKeys() {
  const std::string at = "comparisons[].", row = at + "statistics[].";
  ResultColumns keys;
  const auto add = [&](const ResultColumns& more) { AddColumns(more, keys); };
  add({
      {at + "first", "name of the first configuration"},
      {at + "second", "name of the second configuration; differences are second - first"},
      {at + "scenes", "number of scenes that both have"},
      {at + "scenes_of_first_only", "number of scenes that only the first has"},
      {at + "scenes_of_second_only", "number of scenes that only the second has"},
      {row + "key", "key of the statistic, such as recall_30_50"},
      {row + "name", "statistic in words"},
      {row + "before", "value of the first; rates are 0..1, errors have the unit in name"},
      {row + "after", "value of the second"},
      {row + "difference", "after - before"},
  });
  add(IntervalKeys(row + "difference_ci95", "95 % interval of difference"));
  add({
      {row + "p_value", "probability of such a difference if there is none"},
      {row + "test", "test that gave p_value: mcnemar or sign_flip"},
      {row + "scenes", "number of scenes with data in either run"},
      {row + "discordant_scenes", "number of scenes in which the runs differ"},
      {row + "scenes_needed",
       "number of scenes that shows a difference of this size with power 0.8 at level 0.05; null "
       "if unknown"},
      {row + "odds_ratio", "odds ratio; only if each scene has one outcome"},
  });
  add(IntervalKeys(row + "odds_ratio_ci95",
                   "95 % interval of odds_ratio; null for an infinite end"));
  return keys;
}

std::string ComparisonJson(std::span<const ConfigurationComparison> comparisons) {
  nlohmann::ordered_json json;
  json["comparisons"] = nlohmann::ordered_json::array();
  for (const ConfigurationComparison& comparison : comparisons) {
    nlohmann::ordered_json entry{{"first", comparison.before}, {"second", comparison.after}};
    entry.update(nlohmann::ordered_json::parse(PairedJson(comparison.paired)));
    json["comparisons"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

}  // namespace pickbed::eval
