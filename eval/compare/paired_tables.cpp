#include "eval/compare/paired_tables.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace pickbed::eval {
namespace {

// Formats rates in percent, errors in their unit.
std::string ValueText(const PairedFigure& figure, double value) {
  return figure.is_rate ? PercentText(value) : fmt::format("{:.3g}", value);
}

std::string DifferenceText(const PairedFigure& figure) {
  const auto signed_text = [&](double value) {
    return std::isfinite(value) ? fmt::format("{:+.3g}", value) : std::string("-");
  };
  const Interval& ci95 = figure.difference_ci95;
  if (figure.is_rate) return PointsText(figure.difference(), ci95);
  return fmt::format("{} [{}, {}]", signed_text(figure.difference()), signed_text(ci95.low),
                     signed_text(ci95.high));
}

TableCells CellsOf(const PairedComparison& comparison, const std::string& before,
                   const std::string& after) {
  TableCells cells{{"statistic", before, after, "difference [95 %]", "p", "scenes", "that differ",
                    "scenes needed"}};
  for (const PairedFigure& figure : comparison.figures) {
    cells.push_back({figure.name, ValueText(figure, figure.before), ValueText(figure, figure.after),
                     DifferenceText(figure), fmt::format("{:.3g}", figure.p_value),
                     std::to_string(figure.scenes), std::to_string(figure.discordant_scenes),
                     figure.scenes_needed ? std::to_string(*figure.scenes_needed) : ""});
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
      "{} minus {}, on the {} scenes that both have; rates in percentage points, errors on the "
      "parts that both found, of the surest pose on each. p: McNemar's exact test where a scene "
      "gives one outcome, else signs flipped by scene. Scenes needed: to show a difference of "
      "this size with power .8 at the level .05; told of rates, not of medians.",
      second, first, comparison.scenes);
  if (comparison.before_only + comparison.after_only > 0) {
    text += fmt::format(" Left out are {} scenes that only the first has and {} of the second.",
                        comparison.before_only, comparison.after_only);
  }
  return {fmt::format("Paired differences: {} against {}", second, first), text,
          CellsOf(comparison, first, second)};
}

std::vector<ConfigurationComparison> CompareWithFirst(
    const std::vector<PairedConfiguration>& configurations) {
  std::vector<ConfigurationComparison> comparisons;
  for (size_t i = 1; i < configurations.size(); ++i) {
    if (SceneKey(configurations[i].identity) != SceneKey(configurations[0].identity)) continue;
    comparisons.push_back(CompareConfigurations(configurations[0], configurations[i]));
  }
  return comparisons;
}

std::string ComparisonText(std::span<const ConfigurationComparison> comparisons) {
  std::string text;
  for (const ConfigurationComparison& comparison : comparisons) {
    text += fmt::format("A is {}, B is {}; {}\n", comparison.before, comparison.after,
                        PairedTable(comparison.paired));
  }
  return text;
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
