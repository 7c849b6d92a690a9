#include "eval/report_pairs.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace pickbed {
namespace {

// Rates in percent, errors as they are.
std::string ValueText(const PairedFigure& figure, double value) {
  return figure.is_rate ? fmt::format("{:.1f} %", 100 * value) : fmt::format("{:.3g}", value);
}

std::string DifferenceText(const PairedFigure& figure) {
  const auto signed_text = [&](double value) {
    if (!std::isfinite(value)) return std::string("-");
    return figure.is_rate ? fmt::format("{:+.1f}", 100 * value) : fmt::format("{:+.3g}", value);
  };
  const Interval& ci95 = figure.difference_ci95;
  return fmt::format("{} [{}, {}]", signed_text(figure.difference()), signed_text(ci95.low),
                     signed_text(ci95.high));
}

TableCells CellsOf(const PairedComparison& comparison, const std::string& before,
                   const std::string& after) {
  TableCells cells{{"figure", before, after, "difference [95 %]", "p", "scenes", "that differ",
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

PointComparison ComparePoints(const PairedPoint& before, const PairedPoint& after) {
  return {before.trials->name, after.trials->name,
          ComparePaired(before.trials->trials, after.trials->trials, before.trials->bands)};
}

ReportTable PairedReport(const PointComparison& compared) {
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

std::vector<PointComparison> CompareWithFirst(const std::vector<PairedPoint>& points) {
  std::vector<PointComparison> comparisons;
  for (size_t i = 1; i < points.size(); ++i) {
    if (SceneKey(points[i].identity) != SceneKey(points[0].identity)) continue;
    comparisons.push_back(ComparePoints(points[0], points[i]));
  }
  return comparisons;
}

std::string ComparisonText(std::span<const PointComparison> comparisons) {
  std::string text;
  for (const PointComparison& comparison : comparisons) {
    text += fmt::format("A is {}, B is {}; {}\n", comparison.before, comparison.after,
                        PairedTable(comparison.paired));
  }
  return text;
}

std::string ComparisonJson(std::span<const PointComparison> comparisons) {
  nlohmann::ordered_json json;
  json["comparisons"] = nlohmann::ordered_json::array();
  for (const PointComparison& comparison : comparisons) {
    nlohmann::ordered_json entry{{"first", comparison.before}, {"second", comparison.after}};
    entry.update(nlohmann::ordered_json::parse(PairedJson(comparison.paired)));
    json["comparisons"].push_back(std::move(entry));
  }
  return json.dump(2) + "\n";
}

}  // namespace pickbed
